#include "apps/robot/ros2_rules.hpp"

#include <algorithm>

#include "net/ros2/convert.hpp"
#include "rt/graph_check.hpp"

namespace sinew::app {
namespace {

std::vector<std::string> topic_names(const rt::Graph& graph, bool external) {
  std::vector<std::string> names;
  for (const rt::TopicSpec& t : graph.spec().topics)
    if (external && t.external) names.push_back(t.name);
  for (const rt::GraphTopic& t : graph.topics())
    if (!external) names.push_back(t.name);
  return names;
}

void check_bridged(const ros2::BridgeSpec& spec, const ros2::BridgedTopic& topic, bool out, const rt::Graph& graph,
                   std::vector<rt::Problem>& problems) {
  const std::string side = topic.key + (out ? ".from" : ".to");
  const std::vector<std::string> names = topic_names(graph, !out);
  if (std::find(names.begin(), names.end(), topic.topic) == names.end()) {
    problems.push_back({topic.line, side, rt::quoted(topic.topic),
                        out ? "a topic of this robot: one of " + rt::listed_for(topic.topic, names)
                            : "a topic with writer = \"external\"" +
                                  (names.empty() ? std::string(", of which there is none")
                                                 : ": one of " + rt::listed_for(topic.topic, names))});
    return;
  }
  const std::vector<std::string> known = ros2::ros_types(out);
  const std::string type = ros2::long_name(topic.type);
  if (!ros2::known_types(spec.distro).find(type)) {
    problems.push_back({topic.line, topic.key + ".type", rt::quoted(topic.type),
                        "sinew_msgs/msg/NAME of an own message, or one of " + rt::listed_for(type, known)});
    return;
  }
  const msg::TypeInfo& own = *graph.topics()[graph.find_topic(topic.topic)].type;
  std::string why;
  const bool good = out ? ros2::Outgoing::make(spec.distro, type, own, topic.options, why) != nullptr
                        : ros2::Incoming::make(spec.distro, type, own, topic.options, why) != nullptr;
  if (!good) problems.push_back({topic.line, topic.key, type + " of " + rt::quoted(topic.topic), why});
}

}  // namespace

std::vector<rt::Problem> check_ros2(const RobotFile& robot, const rt::Graph& graph) {
  std::vector<rt::Problem> problems;
  if (!robot.ros2) return problems;
  const ros2::BridgeSpec& spec = *robot.ros2;
  for (const ros2::BridgedTopic& topic : spec.out) check_bridged(spec, topic, true, graph, problems);
  for (const ros2::BridgedTopic& topic : spec.in) check_bridged(spec, topic, false, graph, problems);
  return problems;
}

}  // namespace sinew::app
