#include "apps/robot_file/ros2_reader.hpp"

#include <algorithm>
#include <cmath>

#include "rt/graph_check.hpp"

namespace sinew::app {
namespace {

using ros2::BridgedTopic;
using ros2::BridgeSpec;
using ros2::Qos;

constexpr std::string_view kRosName =
    "a ROS 2 name: tokens of a-z, A-Z, 0-9 and _ with / between; / or ~/ may come first";

/// `qos = "sensor_data"`, or a table with a profile and what differs from it.
void read_qos(TomlReader& r, Qos& qos) {
  const toml::node* node = r.raw().get("qos");
  if (!node || !node->is_table()) {
    r.read_choice("qos", qos, ros2::kQosProfiles);
    return;
  }
  r.table("qos", [&qos](TomlReader& q) {
    q.read_choice("profile", qos, ros2::kQosProfiles);
    q.read_choice("reliability", qos.reliable, {{"reliable", true}, {"best_effort", false}});
    q.read_choice("durability", qos.transient_local, {{"transient_local", true}, {"volatile", false}});
    std::int64_t depth = 0;
    if (q.read("depth", depth, 1, ros2::kMostDepth)) qos.depth = static_cast<std::uint32_t>(depth);
  });
}

/// An array of numbers, as many as one of `counts`.
void read_numbers(TomlReader& r, std::string_view key, std::vector<double>& out,
                  std::initializer_list<std::size_t> counts, std::string_view allowed) {
  const toml::node* node = r.take(key);
  if (!node) return;
  const toml::array* array = node->as_array();
  std::vector<double> numbers;
  for (std::size_t i = 0; array && i < array->size(); ++i)
    if (const auto v = (*array)[i].value<double>(); v && std::isfinite(*v) && !(*array)[i].is_boolean())
      numbers.push_back(*v);
  const bool fits = array && numbers.size() == array->size() &&
                    std::find(counts.begin(), counts.end(), numbers.size()) != counts.end();
  if (fits)
    out = std::move(numbers);
  else
    r.problem(*node, key, std::string(allowed));
}

void read_map_options(TomlReader& r, ros2::MapOptions& o) {
  r.read("frame", o.frame, "the name of a frame");
  r.read("child_frame", o.child_frame, "the name of a frame");
  r.read("field", o.field, "a number of the message, such as \"gyro_radps.x\"");
  r.read("object", o.object, "the class_id of a detection");
  r.read("field_of_view_rad", o.field_of_view_rad, 0.0, 6.3);
  r.read("min_m", o.min_m, 0.0, 1e5);
  r.read("max_m", o.max_m, 0.0, 1e5);
  r.read("geoid_m", o.geoid_m, -200.0, 200.0);
  read_numbers(r, "camera", o.camera, {4}, "[fx, fy, cx, cy] in pixels");
  if (!o.camera.empty() && !(o.camera[0] > 0 && o.camera[1] > 0))
    r.problems().push_back({r.line(), r.full("camera"), rt::quoted(""), "[fx, fy, cx, cy]; fx and fy above 0"});
  read_numbers(r, "distortion", o.distortion, {4, 5}, "[k1, k2, p1, p2] or [k1, k2, p1, p2, k3]");
  std::vector<rt::Located<std::string>> joints;
  if (!r.read_names("joints", joints)) return;
  for (const auto& joint : joints) o.joints.push_back(joint.value);
  if (joints.size() > msg::kMaxChannels)
    r.problems().push_back({r.line(), r.full("joints"), std::to_string(joints.size()) + " names",
                            "at most " + std::to_string(msg::kMaxChannels) + " names"});
}

void read_bridged(TomlReader& r, const char* robot_side, std::vector<BridgedTopic>& all) {
  BridgedTopic topic;
  topic.line = r.line();
  topic.key = r.path();
  std::string name;  // only for files that extend others
  r.read("name", name);
  r.require(robot_side, topic.topic, "a topic of this robot; it is required");
  r.require("topic", topic.ros, "the name of a ROS 2 topic; it is required");
  r.require("type", topic.type, "a ROS 2 type, e.g. \"sensor_msgs/msg/Imu\"; it is required");
  if (!topic.ros.empty() && !ros2::is_ros_name(topic.ros))
    r.problems().push_back({r.line(), r.full("topic"), rt::quoted(topic.ros), std::string(kRosName)});
  read_qos(r, topic.qos);
  r.read("rate_hz", topic.rate_hz, 0.01, 10000.0);
  read_map_options(r, topic.options);
  if (all.size() == ros2::kMostBridged)
    r.problems().push_back({r.line(), r.path(), "", "at most " + std::to_string(ros2::kMostBridged) + " topics"});
  else
    all.push_back(std::move(topic));
}

void read_frame(TomlReader& r, BridgeSpec& spec) {
  ros2::StaticFrame frame;
  std::string name;
  r.read("name", name);
  r.require("parent", frame.parent, "the name of a frame; it is required");
  r.require("child", frame.child, "the name of a frame; it is required");
  std::vector<double> xyz, quat;
  read_numbers(r, "xyz_m", xyz, {3}, "[x, y, z] in metres");
  read_numbers(r, "quat_wxyz", quat, {4}, "[w, x, y, z], of length 1");
  std::copy(xyz.begin(), xyz.end(), frame.xyz_m);
  double length2 = 0;
  for (const double v : quat) length2 += v * v;
  if (!quat.empty() && std::abs(length2 - 1) > 1e-3)
    r.problems().push_back(
        {r.line(), r.full("quat_wxyz"), "length " + std::to_string(std::sqrt(length2)), "[w, x, y, z], of length 1"});
  std::copy(quat.begin(), quat.end(), frame.quat_wxyz);
  spec.frames.push_back(std::move(frame));
}

}  // namespace

void read_ros2(TomlReader& r, RobotFile& robot) {
  BridgeSpec spec;
  spec.line = r.line();
  if (!r.has("distro")) r.missing("distro", "\"humble\" or \"jazzy\", of the graph's other nodes; it is required");
  r.read_choice("distro", spec.distro, ros2::kDistros);
  spec.node = robot.graph.robot;
  std::replace(spec.node.begin(), spec.node.end(), '-', '_');
  r.read("node", spec.node);
  if (!spec.node.empty() && !ros2::is_node_name(spec.node))
    r.problems().push_back({r.line(), r.full("node"), rt::quoted(spec.node), "letters, digits and _, no digit first"});
  r.read("namespace", spec.name_space);
  if (spec.name_space != "/" && !(spec.name_space.starts_with('/') && ros2::is_ros_name(spec.name_space)))
    r.problems().push_back(
        {r.line(), r.full("namespace"), rt::quoted(spec.name_space), "\"/\", or a name that begins with /"});
  r.read_choice(
      "clock", spec.clock,
      {{"none", ros2::ClockUse::none}, {"publish", ros2::ClockUse::publish}, {"follow", ros2::ClockUse::follow}});
  // Who publishes /clock says with it what time is; who follows it has that clock's.
  if (spec.clock != ros2::ClockUse::none) spec.stamps = ros2::Stamps::robot;
  r.read_choice("stamps", spec.stamps, {{"wall", ros2::Stamps::wall}, {"robot", ros2::Stamps::robot}});
  if (spec.clock != ros2::ClockUse::none && spec.stamps == ros2::Stamps::wall)
    r.problems().push_back(
        {r.line(), r.full("stamps"), "\"wall\"", "\"robot\" with a clock: stamps are of the time that /clock says"});
  r.read("rosout", spec.rosout);
  r.read("diagnostics", spec.diagnostics);
  r.read("parameters", spec.parameters);
  r.array_of_tables("out", [&](TomlReader& t) { read_bridged(t, "from", spec.out); });
  r.array_of_tables("in", [&](TomlReader& t) { read_bridged(t, "to", spec.in); });
  r.array_of_tables("frame", [&](TomlReader& t) { read_frame(t, spec); });
  robot.ros2 = std::move(spec);
}

}  // namespace sinew::app
