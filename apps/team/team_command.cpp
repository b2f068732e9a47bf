#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>

#include "apps/command/json.hpp"
#include "apps/command/number_check.hpp"
#include "apps/team/commands.hpp"
#include "apps/team/team_run.hpp"
#include "hal/linux/process.hpp"

namespace sinew::app {
namespace {

/// One line for each robot about its radio, from the simulator's last report.
std::string radio_line(const Json& report, const std::string& robot) {
  const auto& robots = report.is_object() && report.contains("robots") ? report["robots"] : Json::object();
  if (!robots.contains(robot) || !robots[robot].contains("radio")) return {};
  const Json& radio = robots[robot]["radio"];
  const auto count = [&](const char* key) { return radio.value(key, std::uint64_t{0}); };
  if (count("sent") + count("heard") + count("rx_lost") + count("out_of_reach") == 0) return {};
  return fmt::format("{}: radio sent {}, heard {}, lost {} of mates by chance and {} out of reach, {} for lack of air",
                     robot, count("sent"), count("heard"), count("rx_lost"), count("out_of_reach"),
                     count("tx_lost") + count("rx_full"));
}

int report(const TeamRunOptions& options, const TeamEnd& end) {
  const auto good = static_cast<std::size_t>(std::ranges::count(end.members, kDone, &MemberEnd::code));
  if (options.json) {
    Json robots = Json::object();
    for (const MemberEnd& m : end.members) robots[m.name] = {{"exit_code", m.code}, {"summary", m.summary}};
    const Json all = {{"robots", robots}, {"plant", end.plant}, {"good", good}};
    std::printf("%s\n", all.dump().c_str());
  } else {
    for (const MemberEnd& m : end.members)
      if (const std::string line = radio_line(end.plant, m.name); !line.empty()) std::printf("%s\n", line.c_str());
    std::printf("team: %zu of %zu robots did well\n", good, end.members.size());
  }
  return end.code;
}

int run_team(const TeamRunOptions& options, const rt::ModuleTypes& types) {
  static_cast<void>(hal::stop_requested());  // from here on a signal only asks for the end
  const auto setup = set_up_team(options, types);
  if (!setup) return kNotBegun;
  const TeamEnd end = run_members(*setup, options);
  return end.members.empty() ? end.code : report(options, end);
}

void describe_team(CLI::App& team, TeamRunOptions& o) {
  team.add_option("robots", o.robots, "robot files, one for each robot")->required()->type_name(kRobotFileHint);
  team.add_flag("--virtual", o.virtual_time,
                "virtual time: as fast as the machine can, the same bytes for the same seed");
  team.add_option("--seed", o.seed, "of the world and of each robot, instead of the files'")
      ->check(whole())
      ->type_name("N");
  team.add_option("--duration", o.duration_s, "stop after so many seconds; 0: when the missions end")
      ->check(number(0))
      ->type_name("S");
  team.add_option("--rate", o.rate, "real time: robot seconds per second, for a plant slower than life")
      ->check(number(0.001, 1000.0))
      ->excludes("--virtual");
  team.add_option("--set", o.set, "[ROBOT/]KEY=VALUE as `run --set` has it; without ROBOT for all; may be repeated")
      ->allow_extra_args(false)
      ->type_name(kSettingHint);
  team.add_option("--fault", o.faults,
                  "[ROBOT/]FAULT for the simulator to play, e.g. ant/radio:off@5+3; without ROBOT for all; may be "
                  "repeated")
      ->allow_extra_args(false)
      ->type_name("FAULT");
  team.add_option("--plant-arg", o.plant_args,
                  "one more argument for sinew-sim (see sinew-sim --help); may be repeated")
      ->allow_extra_args(false)
      ->type_name("ARG");
  team.add_option("--camera", o.camera, "size of the cameras' frames")->type_name("WxH");
  team.add_option("--runs", o.record_folder, "folder of the recordings (default: the robot files', or runs)");
  team.add_flag("--no-record", o.no_record, "no recordings");
  CLI::Option& quiet = *team.add_flag("--quiet", o.quiet, "only each mission's result, one line");
  team.add_flag("--verbose", o.verbose, "at the end also each robot's threads, modules, losses and hashes")
      ->excludes(&quiet);
  team.add_flag("--json", o.json, "only one JSON object with each robot's summary and the simulator's, at the end");
}

}  // namespace

void add_team_command(CLI::App& app, CommandContext& context) {
  const auto options = std::make_shared<TeamRunOptions>();
  CLI::App& team = *app.add_subcommand("team", "run several robots in one simulated world, each in its own process");
  describe_team(team, *options);
  team.callback([&context, options] {
    context.action = [&types = context.types, options] { return run_team(*options, types); };
  });
}

}  // namespace sinew::app
