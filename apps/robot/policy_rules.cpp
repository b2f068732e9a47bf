#include "apps/robot/policy_rules.hpp"

namespace sinew::app {

std::vector<rt::Problem> check_policies(const RobotFile& robot, const rt::Graph& graph) {
  std::vector<rt::Problem> problems;
  const auto type_of = [&](const std::string& topic) { return graph.topics()[graph.find_topic(topic)].type; };
  for (const PolicyTable& p : robot.policies) {
    const auto network = policy::load_network(p.options, *p.file, problems);
    if (!network) continue;
    policy::PlanTypes types;
    for (const std::string& topic : policy::observed_topics(p.options)) types.topics.push_back(type_of(topic));
    for (const std::string& port : policy::commanded_ports(p.options))
      types.ports.push_back(type_of(rt::topic_name(p.options.name, port)));
    policy::make_plan(p.options, types, *network, problems);
  }
  return problems;
}

std::vector<std::string> describe_policies(const RobotFile& robot) {
  std::vector<std::string> lines;
  for (const PolicyTable& p : robot.policies) {
    std::vector<rt::Problem> problems;
    if (const auto network = policy::load_network(p.options, *p.file, problems))
      lines.push_back(policy::describe(p.options, *p.file, *network));
  }
  return lines;
}

}  // namespace sinew::app
