#pragma once
// What makes a robot a node of a ROS 2 graph besides its topics: who it is, its clock, log, diagnostics and parameters.
// Each function writes or reads the bytes of one message.
// Thread:  any.   RT: no.
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "net/ros2/convert.hpp"

namespace sinew::ros2 {

using Guid = std::array<std::uint8_t, 16>;

/// A node and its endpoints, as `ros2 node info` shows them.
struct NodeInfo {
  std::string name, name_space;  // "quad", "/"
  std::vector<Guid> readers, writers;
};
/// rmw_dds_common/msg/ParticipantEntitiesInfo, for the topic ros_discovery_info: reliable, transient local, depth 1.
Bytes discovery_info(Distro distro, const Guid& participant, std::span<const NodeInfo> nodes);

/// rosgraph_msgs/msg/Clock.
Bytes clock_message(std::int64_t ns);
std::optional<std::int64_t> read_clock(std::span<const std::uint8_t> in);

/// Levels of rcl_interfaces/msg/Log.
enum class LogLevel : std::uint8_t { debug = 10, info = 20, warn = 30, error = 40, fatal = 50 };
Bytes log_message(std::int64_t stamp_ns, LogLevel level, std::string_view node, std::string_view text);

enum class Health : std::uint8_t { ok = 0, warn = 1, error = 2, stale = 3 };
struct Diagnosis {
  Health health = Health::ok;
  std::string name, message, hardware;
  std::vector<std::pair<std::string, std::string>> values;
};
/// diagnostic_msgs/msg/DiagnosticArray.
Bytes diagnostics_message(std::int64_t stamp_ns, std::span<const Diagnosis> all);

/// tf2_msgs/msg/TFMessage, for /tf_static.
Bytes static_frames_message(std::int64_t stamp_ns, std::span<const StaticFrame> frames);

// ---- parameters

using ParameterValue = std::variant<std::monostate, bool, std::int64_t, double, std::string>;  // monostate: not set
struct Parameter {
  std::string name;  // "attitude.kp_rate"
  ParameterValue value;
};
/// rcl_interfaces/msg/ParameterEvent, for /parameter_events. `node`: with its namespace, "/quad".
Bytes parameter_event(std::int64_t stamp_ns, std::string_view node, std::span<const Parameter> added,
                      std::span<const Parameter> changed);
struct ParameterEvent {
  std::string node;
  std::vector<Parameter> set;  // new and changed ones
};
/// None: no such message, or with a value of a type that no parameter here has (an array).
std::optional<ParameterEvent> read_parameter_event(std::span<const std::uint8_t> in);

/// The five services of a node's parameters, as Cyclone DDS's RMW carries them: a request is its head (client and
/// number, 8 bytes each), then the request; the reply has the same head. Source:  ros2/rmw_cyclonedds, branch humble,
/// rmw_node.cpp (cdds_request_header_t), serdata.cpp.
enum class ParameterService : std::uint8_t { get, get_types, set, list, describe };
inline constexpr std::pair<std::string_view, ParameterService> kParameterServices[] = {
    {"get_parameters", ParameterService::get},
    {"get_parameter_types", ParameterService::get_types},
    {"set_parameters", ParameterService::set},
    {"list_parameters", ParameterService::list},
    {"describe_parameters", ParameterService::describe}};
/// DDS's type of the service's request or reply.
std::string service_type(ParameterService service, bool request);

struct ServiceRequest {
  std::array<std::uint8_t, 16> head{};
  std::vector<std::string> names;  // get, get_types, describe; of list the prefixes
  std::vector<Parameter> set;
};
std::optional<ServiceRequest> read_request(ParameterService service, std::span<const std::uint8_t> in);

/// What is known of a parameter.
struct ParameterInfo {
  Parameter parameter;
  std::string doc;
  std::optional<double> min, max;
};
/// Of get, get_types, list and describe. `known`: all parameters.
Bytes service_reply(ParameterService service, const ServiceRequest& request, std::span<const ParameterInfo> known);
/// Of set: for each parameter of the request "" or why not.
Bytes set_reply(const ServiceRequest& request, std::span<const std::string> refused);

}  // namespace sinew::ros2
