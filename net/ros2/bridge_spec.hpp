#pragma once
// What a robot shows to a ROS 2 graph, and takes from it: `[ros2]` of its robot file.
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "net/ros2/convert.hpp"

namespace sinew::ros2 {

/// As ROS 2 names it: rmw_qos_profile_t.
struct Qos {
  bool reliable = true, transient_local = false;
  std::uint32_t depth = 10;
  friend bool operator==(const Qos&, const Qos&) = default;
};

/// Source:  rmw/qos_profiles.h, rclcpp/qos.hpp.
inline constexpr std::pair<std::string_view, Qos> kQosProfiles[] = {
    {"default", {true, false, 10}},          {"sensor_data", {false, false, 5}},
    {"parameters", {true, false, 1000}},     {"parameter_events", {true, false, 1000}},
    {"services_default", {true, false, 10}}, {"clock", {false, false, 1}},
    {"rosout", {true, true, 1000}}};
inline constexpr std::uint32_t kMostDepth = 10000;

/// One topic in one direction.
struct BridgedTopic {
  int line = 0;
  std::string key;    // of the robot file: "ros2.out.0"
  std::string topic;  // of the robot: "filter.state"
  std::string ros;    // as written: "odom", "/tf", "~/state"
  std::string type;   // "nav_msgs/msg/Odometry"
  Qos qos{};
  double rate_hz = 0;  // at most so many a second; 0: each message
  MapOptions options{};
};

enum class Stamps : std::uint8_t { wall, robot };              // header stamps: since 1970, or the robot's clock
enum class ClockUse : std::uint8_t { none, publish, follow };  // of /clock

struct BridgeSpec {
  int line = 0;
  Distro distro = Distro::humble;
  std::string node{}, name_space = "/";
  Stamps stamps = Stamps::wall;
  ClockUse clock = ClockUse::none;
  bool rosout = true, diagnostics = true, parameters = true;
  std::vector<BridgedTopic> out{}, in{};
  std::vector<StaticFrame> frames{};
};

inline constexpr std::size_t kMostBridged = 128;  // topics of each direction

/// True for "odom", "camera/image_raw", "/tf", "~/state".
/// Source:  design.ros2.org/articles/topic_and_service_names.html
bool is_ros_name(std::string_view name);
/// A node's name: letters, digits and _, no digit first.
bool is_node_name(std::string_view name);
/// The whole name: with the namespace, and for ~ the node. "/quad/odom".
std::string full_name(const BridgeSpec& spec, std::string_view ros);
/// "/quad": the node with its namespace.
std::string node_path(const BridgeSpec& spec);
/// DDS's name of a topic: "rt/quad/odom".
std::string dds_topic(std::string_view full_name);

}  // namespace sinew::ros2
