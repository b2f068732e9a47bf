#include "apps/team/team_setup.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "apps/command/command.hpp"
#include "apps/robot/board_rules.hpp"
#include "apps/robot_file/world_options.hpp"
#include "apps/run/run_setup.hpp"
#include "robots/robot_kind.hpp"

namespace sinew::app {
namespace {

/// The robot that an option begins with, cut off; empty: all.
std::string cut_robot(std::string& option, std::string_view before) {
  const auto slash = option.find('/');
  if (slash == std::string::npos || slash > option.find_first_of(before)) return {};
  std::string name = option.substr(0, slash);
  option.erase(0, slash + 1);
  return name;
}

std::string names_of(const std::vector<TeamMember>& members) {
  std::string all;
  for (const TeamMember& m : members) all += (all.empty() ? "" : ", ") + m.name;
  return all;
}

/// Options of the form "[ROBOT/]TEXT" that are this robot's, without its name.
std::vector<std::string> own_options(const std::vector<std::string>& all, std::string_view before,
                                     const std::string& robot) {
  std::vector<std::string> own;
  for (std::string option : all)
    if (const std::string name = cut_robot(option, before); name.empty() || name == robot) own.push_back(option);
  return own;
}

/// An option of a robot that is none; empty: there is none.
std::string stray_option(const char* what, const std::vector<std::string>& all, std::string_view before,
                         const std::vector<TeamMember>& members) {
  for (const std::string& option : all) {
    std::string rest = option;
    const std::string name = cut_robot(rest, before);
    if (!name.empty() && std::ranges::find(members, name, &TeamMember::name) == members.end())
      return fmt::format("{} {}: no robot {}; there are {}", what, option, name, names_of(members));
  }
  return {};
}

std::string shared_misfit(const TeamMember& first, const TeamMember& other) {
  const SimTable &a = first.robot.sim, &b = other.robot.sim;
  const auto both = [&](const char* what, auto x, auto y) {
    return fmt::format("{} and {} share a world: {} is {} in one and {} in the other", first.name, other.name, what, x,
                       y);
  };
  if (a.world != b.world) return both("sim.world", a.world, b.world);
  if (a.camera_width != b.camera_width) return both("sim.camera_width", a.camera_width, b.camera_width);
  if (a.camera_height != b.camera_height) return both("sim.camera_height", a.camera_height, b.camera_height);
  for (const plant::WorldOption& o : robots::find_world(a.world)->options) {
    if (o.per_robot) continue;
    const auto text = [&](const SimTable& sim) {
      const auto it = sim.options.find(o.key);
      return it == sim.options.end() ? std::string("left out") : fmt::format("{}", it->second);
    };
    if (text(a) != text(b)) return both(("sim." + std::string(o.key)).c_str(), text(a), text(b));
  }
  return {};
}

std::string team_misfit(const TeamMember& one, const TeamMember& other) {
  if (!one.robot.team || !other.robot.team) return {};
  const team::LinkOptions &a = one.robot.team->link, &b = other.robot.team->link;
  if (a.team != b.team)
    return fmt::format("{} is of the team {} and {} of the team {}: they do not hear each other (team.team)", one.name,
                       a.team, other.name, b.team);
  if (a.robot == b.robot)
    return fmt::format("{} and {} both have the number {} in the team (team.robot)", one.name, other.name, a.robot);
  for (const team::Mate& mate : a.mates)
    if (mate.name == other.name && mate.robot != b.robot)
      return fmt::format("{} takes {} for number {}, and its own file says {} (team.members, team.robot)", one.name,
                         other.name, mate.robot, b.robot);
  return {};
}

void add_plant_options(PlantRequest& plant, const std::vector<TeamMember>& members) {
  const auto add = [&](std::string argument) { plant.extra.push_back(std::move(argument)); };
  for (const TeamMember& m : members) add("--robot=" + m.name);
  for (const TeamMember& m : members)
    if (!m.robot.sim.body_file.empty()) add(fmt::format("--body={}={}", m.name, m.robot.sim.body_file));
  for (const plant::WorldOption& o : robots::find_world(plant.world)->options)
    for (const TeamMember& m : members) {
      const auto value = m.robot.sim.options.find(o.key);
      if (value == m.robot.sim.options.end()) continue;
      add(o.per_robot ? fmt::format("--{}={}={}", o.option, m.name, value->second)
                      : fmt::format("--{}={}", o.option, value->second));
      if (!o.per_robot) break;  // the same in all files
    }
}

std::optional<TeamMember> load_member(const std::string& file, const TeamRunOptions& options,
                                      const rt::ModuleTypes& types) {
  const LoadedRobot loaded = load_robot(file);
  RunOptions run;
  run.robot = file;
  run.virtual_time = options.virtual_time;
  run.seed = options.seed;
  run.camera = options.camera;
  run.plant = "auto";  // so that it takes settings of the world
  run.set = own_options(options.set, ".=", loaded.robot.graph.robot);
  auto prepared = prepare(run, types);
  if (!prepared) return std::nullopt;
  const auto problems = check_boards(prepared->graph->spec(), {options.virtual_time, false});
  for (const auto& p : problems) std::fprintf(stderr, "%s\n", to_string(p, prepared->robot).c_str());
  if (!problems.empty()) return std::nullopt;
  TeamMember member{prepared->graph->spec().robot, std::move(prepared->robot), {}};
  if (!needs_plant(prepared->graph->spec())) {
    fail(fmt::format("{}: a robot of a simulated team has the board sim", file));
    return std::nullopt;
  }
  for (const std::string& fault : own_options(options.faults, ":", member.name))
    if (const std::string why = unfelt_fault(prepared->graph->spec(), fault); !why.empty()) {
      fail(fmt::format("{}: {}", member.name, why));
      return std::nullopt;
    }
  std::vector<std::string>& argv = member.arguments;
  argv = {"run", file, options.virtual_time ? "--virtual" : "--plain"};
  const auto add = [&](const char* option, const std::string& value) {
    if (!value.empty()) argv.insert(argv.end(), {option, value});
  };
  if (options.seed) add("--seed", std::to_string(*options.seed));
  if (options.rate != 1) add("--rate", fmt::format("{}", options.rate));
  if (options.duration_s > 0) add("--duration", fmt::format("{}", options.duration_s));
  add("--camera", options.camera);
  add("--runs", options.record_folder);
  for (const std::string& setting : run.set)
    if (!setting.starts_with("sim.")) add("--set", setting);
  if (options.no_record) argv.emplace_back("--no-record");
  if (options.quiet) argv.emplace_back("--quiet");
  if (options.verbose) argv.emplace_back("--verbose");
  if (options.json) argv.emplace_back("--json");
  return member;
}

}  // namespace

std::string misfit(const std::vector<TeamMember>& members) {
  const SimTable& sim = members.front().robot.sim;
  const plant::WorldInfo* const world = robots::find_world(sim.world);
  if (!world) return "no world " + sim.world;
  if (members.size() > world->most_robots)
    return fmt::format("the world {} has room for {} robot{}, not {}", sim.world, world->most_robots,
                       world->most_robots == 1 ? "" : "s", members.size());
  for (std::size_t i = 0; i < members.size(); ++i)
    for (std::size_t j = 0; j < members.size(); ++j) {
      if (i == j) continue;
      if (members[i].name == members[j].name)
        return fmt::format("two robots are named {}: each has its own name (robot.name)", members[i].name);
      std::string why = i == 0 ? shared_misfit(members[i], members[j]) : std::string();
      if (why.empty()) why = team_misfit(members[i], members[j]);
      if (!why.empty()) return why;
    }
  return {};
}

std::optional<TeamSetup> set_up_team(const TeamRunOptions& options, const rt::ModuleTypes& types) {
  TeamSetup setup;
  for (const std::string& file : options.robots) {
    auto member = load_member(file, options, types);
    if (!member) return std::nullopt;
    setup.members.push_back(std::move(*member));
  }
  std::string why = misfit(setup.members);
  if (why.empty()) why = stray_option("--set", options.set, ".=", setup.members);
  if (why.empty()) why = stray_option("--fault", options.faults, ":", setup.members);
  if (!why.empty()) {
    fail(why);
    return std::nullopt;
  }
  const RobotFile& first = setup.members.front().robot;
  PlantRequest& plant = setup.plant;
  plant.endpoint = "auto";
  plant.world = first.sim.world;
  plant.seed = options.seed.value_or(world_seed(first));
  plant.camera_width = first.sim.camera_width;
  plant.camera_height = first.sim.camera_height;
  plant.lockstep = options.virtual_time;
  add_plant_options(plant, setup.members);
  for (const TeamMember& m : setup.members)
    for (const std::string& fault : own_options(options.faults, ":", m.name))
      plant.extra.insert(plant.extra.end(), {"--fault", m.name + "/" + fault});
  plant.extra.insert(plant.extra.end(), options.plant_args.begin(), options.plant_args.end());
  return setup;
}

}  // namespace sinew::app
