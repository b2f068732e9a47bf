#include "apps/robot/team_rules.hpp"

#include "rt/parameters.hpp"
#include "team/link.hpp"

namespace sinew::app {
namespace {

struct TeamCosts {
  struct Topic {
    const team::Said* said;
    const msg::TypeInfo* type;
    team::SaidCost cost;  // none where the type has pixels
  };
  std::vector<Topic> topics{};
  double overhead = 0, all = 0;  // bytes a second
};

TeamCosts costs_of(const RobotFile& robot, const rt::Graph& graph) {
  TeamCosts costs;
  const team::LinkOptions& link = robot.team->link;
  costs.overhead = team::overhead_bytes_per_s(link, graph.planned_rate_hz(graph.find_topic("mates.state")));
  costs.all = costs.overhead;
  for (const team::Said& said : link.said) {
    const msg::TypeInfo* type = graph.topics()[graph.find_topic(said.topic)].type;
    costs.topics.push_back({&said, type, type->has_bulk() ? team::SaidCost{} : team::cost_of(said, *type)});
    costs.all += costs.topics.back().cost.bytes_per_s;
  }
  return costs;
}

std::string whole(double bytes) {
  return rt::format_number(static_cast<double>(static_cast<std::int64_t>(bytes + 0.5)));
}

/// The types of remote topics, which are those of the inputs that read them.
void check_heard(const rt::Graph& graph, const rt::ModuleSpec& m, std::vector<rt::Problem>& problems) {
  for (const auto& [port, topic] : m.in) {
    if (!rt::is_remote(topic.value)) continue;
    const msg::TypeInfo& type = *graph.topics()[graph.find_topic(topic.value)].type;
    const bool of_all = topic.value.starts_with(std::string(team::kAllMates) + "/");
    const std::string key = "module." + m.name + ".in." + port,
                      is = rt::quoted(topic.value) + " of " + std::string(type.name);
    if (type.has_bulk())
      problems.push_back({topic.line, key, is, "an input without pixels: a frame has 1200 bytes"});
    else if (of_all != team::is_from_mate(type))
      problems.push_back({topic.line, key, is,
                          of_all ? "an input of FromMate<...>, as messages of all mates carry their sender"
                                 : "an input of the mate's own type; FromMate<...> is for mates/TOPIC"});
  }
}

}  // namespace

std::vector<rt::Problem> check_team(const RobotFile& robot, const rt::Graph& graph) {
  std::vector<rt::Problem> problems;
  if (!robot.team) return problems;
  for (const rt::ModuleSpec& m : graph.spec().modules) check_heard(graph, m, problems);
  const TeamCosts costs = costs_of(robot, graph);
  for (const TeamCosts::Topic& t : costs.topics) {
    const std::string key = "team.say." + t.said->topic;
    const std::size_t most = team::most_cdr_bytes(t.said->topic) + wire::kTeamMessageBytes + t.said->topic.size();
    if (t.type->has_bulk())
      problems.push_back({robot.team->said_lines.at(t.said->topic), key, std::string(t.type->name),
                          "a message without pixels: a frame has 1200 bytes"});
    else if (t.cost.message_bytes > most)
      problems.push_back({robot.team->said_lines.at(t.said->topic), key,
                          std::string(t.type->name) + " of " + std::to_string(t.cost.message_bytes) + " bytes",
                          "a message of at most " + std::to_string(most) + " bytes, with its topic's name"});
  }
  std::string text;
  for (const std::string& line : describe_team(robot, graph)) text += (text.empty() ? "" : "; ") + line;
  if (costs.all > robot.team->link.bytes_per_s)
    problems.push_back({robot.team->line, "team.bytes_per_s", whole(robot.team->link.bytes_per_s),
                        "at least " + whole(costs.all) + ", or lower rates: " + text});
  return problems;
}

std::vector<std::string> describe_team(const RobotFile& robot, const rt::Graph& graph) {
  std::vector<std::string> lines;
  if (!robot.team) return lines;
  const TeamCosts costs = costs_of(robot, graph);
  for (const TeamCosts::Topic& t : costs.topics)
    lines.push_back(t.said->topic + " " + whole(t.cost.bytes_per_s) + " B/s (" + std::to_string(t.cost.message_bytes) +
                    " B at " + rt::format_number(t.said->rate_hz) + " Hz)");
  lines.push_back("heads and echoes " + whole(costs.overhead) + " B/s");
  return lines;
}

}  // namespace sinew::app
