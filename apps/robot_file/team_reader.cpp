#include "apps/robot_file/team_reader.hpp"

#include <algorithm>

#include "apps/robot_file/exec_reader.hpp"
#include "rt/graph_check.hpp"

namespace sinew::app {
namespace {

constexpr std::int64_t kMostRobots = 65535;
constexpr std::string_view kMates = team::kAllMates;  // also the name of the module

/// All robots of a team, so that their files can share the list: the own number is left out.
void read_members(TomlReader& r, team::LinkOptions& link) {
  for (const auto& [key, node] : r.raw()) {
    const std::string name(key.str());
    std::int64_t number = 0;
    if (!r.read(name, number, 1, kMostRobots)) continue;
    const auto robot = static_cast<std::uint16_t>(number);
    const bool is_taken =
        std::any_of(link.mates.begin(), link.mates.end(), [&](const auto& m) { return m.robot == robot; });
    if (robot == link.robot) continue;
    if (!rt::is_name(name) || name == kMates)
      r.problem(node, name, "a name of a-z, 0-9 and _ other than \"mates\", which stands for all of them");
    else if (is_taken)
      r.problem(node, name, "a number that no other robot of the team has");
    else if (link.mates.size() == msg::kMaxMates)
      r.problem(node, name, "at most " + std::to_string(msg::kMaxMates) + " other robots");
    else
      link.mates.push_back({name, robot});
  }
}

void read_said(const std::string& topic, TomlReader& r, TeamTable& table) {
  team::Said said;
  said.topic = topic;
  std::int64_t priority = 0;
  if (!r.has("rate_hz")) r.missing("rate_hz", "a number from 0.01 to 1000; it is required");
  r.read("rate_hz", said.rate_hz, 0.01, 1000.0);
  if (r.read("priority", priority, 0, 100)) said.priority = static_cast<int>(priority);
  table.said_lines[topic] = r.line();
  const bool is_topic = !topic.empty() && topic.size() <= wire::kTeamMostTopicBytes && !rt::is_remote(topic) &&
                        std::all_of(topic.begin(), topic.end(), [](char c) { return c > ' ' && c <= '~'; });
  if (!is_topic)
    r.problems().push_back({r.line(), r.path(), rt::quoted(topic), "a topic of this robot, of at most 64 characters"});
  else if (table.link.said.size() == team::kMostSaid)
    r.problems().push_back(
        {r.line(), r.path(), rt::quoted(topic), "at most " + std::to_string(team::kMostSaid) + " topics"});
  else
    table.link.said.push_back(std::move(said));
}

/// Empty: the name is one that this robot can hear; else what would be.
std::string why_not_heard(const std::string& topic, const std::optional<TeamTable>& table) {
  if (!table) return "a topic of this robot: a mate's needs a table [team] with its name";
  const std::string who = topic.substr(0, topic.find('/')), what = topic.substr(who.size() + 1);
  std::vector<std::string> names{std::string(kMates)};
  for (const team::Mate& m : table->link.mates) names.push_back(m.name);
  if (std::find(names.begin(), names.end(), who) == names.end())
    return "NAME/TOPIC, NAME of " + rt::listed_for(who, names);
  const auto [module, port] = rt::split_topic(what);
  const bool is_topic =
      rt::is_name(module) && (port.empty() || rt::is_name(port)) && what.size() <= wire::kTeamMostTopicBytes;
  return is_topic ? "" : "NAME/TOPIC, TOPIC as the mate names it: \"ball.model\"";
}

}  // namespace

void read_team(TomlReader& r, RobotFile& robot) {
  TeamTable table;
  table.line = r.line();
  std::int64_t number = 0;
  if (!r.has("robot")) r.missing("robot", "an integer from 1 to 65535, the number of this robot; it is required");
  if (r.read("robot", number, 1, kMostRobots)) table.link.robot = static_cast<std::uint16_t>(number);
  if (r.read("team", number, 0, INT64_C(0xFFFFFFFF))) table.link.team = static_cast<std::uint32_t>(number);
  r.read("bytes_per_s", table.link.bytes_per_s, 100.0, 1e8);
  r.read("device", table.device, "the name of a radio");
  r.table("members", [&](TomlReader& m) { read_members(m, table.link); });
  r.tables_by_name("say", [&](const std::string& topic, TomlReader& s) { read_said(topic, s, table); });
  read_exec(r, table.exec);
  robot.team = std::move(table);
}

void add_team(RobotFile& robot, Problems& problems) {
  rt::GraphSpec& graph = robot.graph;
  for (const rt::ModuleSpec& m : graph.modules) {
    if (robot.team && m.name == kMates)
      problems.push_back({m.line, "module.mates", "\"mates\"", "another name; [team] makes the module mates"});
    for (const auto& [port, topic] : m.in) {
      if (!rt::is_remote(topic.value)) continue;
      if (const std::string allowed = why_not_heard(topic.value, robot.team); !allowed.empty()) {
        problems.push_back({topic.line, "module." + m.name + ".in." + port, rt::quoted(topic.value), allowed});
        continue;
      }
      std::vector<std::string>& heard = robot.team->link.heard;
      if (std::find(heard.begin(), heard.end(), topic.value) != heard.end()) continue;
      if (heard.size() == team::kMostHeard)
        problems.push_back({topic.line, "module." + m.name + ".in." + port, rt::quoted(topic.value),
                            "at most " + std::to_string(team::kMostHeard) + " remote topics"});
      else
        heard.push_back(topic.value);
    }
  }
  if (!robot.team) return;
  rt::ModuleSpec mates;
  mates.name = kMates;
  mates.type = "team::Link";
  mates.exec = robot.team->exec;
  mates.line = robot.team->line;
  if (!robot.team->device.empty()) mates.params["device"] = {rt::ParamValue(robot.team->device), robot.team->line};
  for (const team::Said& s : robot.team->link.said)
    mates.in[team::say_port(s.topic)] = {s.topic, robot.team->said_lines.at(s.topic)};
  mates.make = [link = robot.team->link] { return std::make_unique<team::Link>(link); };
  graph.modules.push_back(std::move(mates));
}

}  // namespace sinew::app
