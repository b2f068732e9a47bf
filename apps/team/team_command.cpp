#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>

#include "apps/command/json.hpp"
#include "apps/command/number_check.hpp"
#include "apps/run/plant_process.hpp"
#include "apps/team/commands.hpp"
#include "apps/team/team_setup.hpp"
#include "hal/linux/process.hpp"
#include "hal/platform.hpp"

namespace sinew::app {
namespace {

using namespace std::chrono_literals;

/// One robot's `sinew run`.
/// Thread:  owner.
class MemberRun {
 public:
  MemberRun(std::string name, std::size_t name_width, bool prints)
      : name_(std::move(name)), head_(fmt::format("{:<{}} | ", name_, name_width)), prints_(prints) {}

  /// False, after saying why: it could not be started.
  bool start(const std::vector<std::string>& argv) {
    hal::ChildOptions how;
    how.piped = true;
    how.hears_terminal = false;
    auto child = hal::ChildProcess::start(argv, how);
    if (!child) {
      fail(fmt::format("{}: cannot start {}: {}", name_, argv[0], hal::to_string(child.error().code)));
      return false;
    }
    child_ = std::move(*child);
    return true;
  }
  /// Passes on what it has written.
  void look() {
    if (!code_) code_ = child_->poll();
    while (child_->read_output(output_, errors_)) {
    }
    print_lines(output_, stdout, code_.has_value());
    print_lines(errors_, stderr, code_.has_value());
  }

  const std::string& name() const { return name_; }
  hal::ChildProcess* child() { return child_.get(); }
  const std::optional<int>& code() const { return code_; }
  /// Its JSON object, of a run with --json.
  Json summary() const {
    Json said = Json::parse(output_, nullptr, false);
    return said.is_object() ? said : Json();
  }

 private:
  /// Whole lines, and at the end the rest.
  void print_lines(std::string& text, std::FILE* to, bool all) const {
    if (to == stdout && !prints_) return;
    for (auto end = text.find('\n'); !text.empty(); end = text.find('\n')) {
      if (end == std::string::npos && !all) return;
      const std::string line = text.substr(0, end);
      text.erase(0, end == std::string::npos ? end : end + 1);
      std::fprintf(to, "%s%s\n", head_.c_str(), line.c_str());
    }
    std::fflush(to);
  }

  std::string name_, head_;
  bool prints_;
  std::unique_ptr<hal::ChildProcess> child_;
  std::optional<int> code_;
  std::string output_, errors_;
};

bool all_ended(const std::vector<std::unique_ptr<MemberRun>>& runs) {
  return std::ranges::all_of(runs, [](const auto& run) { return run->code().has_value(); });
}

/// Runs them to their end. When the run is interrupted, or one of them could not begin, the others are asked to end.
void watch(std::vector<std::unique_ptr<MemberRun>>& runs) {
  bool asked = false;
  std::vector<std::size_t> ready;
  while (!all_ended(runs)) {
    std::vector<hal::ChildProcess*> running;
    for (const auto& run : runs)
      if (!run->code()) running.push_back(run->child());
    hal::ChildProcess::wait_for_any(running, 200ms, ready);
    for (const auto& run : runs) run->look();
    const auto not_begun = std::ranges::find_if(runs, [](const auto& run) { return run->code() == kNotBegun; });
    if (asked || (not_begun == runs.end() && !hal::stop_requested())) continue;
    asked = true;
    if (not_begun != runs.end() && !all_ended(runs))
      std::fprintf(stderr, "sinew: %s could not begin, so the team does not\n", (*not_begun)->name().c_str());
    for (const auto& run : runs)
      if (!run->code()) run->child()->terminate();
  }
}

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

int report(const TeamRunOptions& options, const std::vector<std::unique_ptr<MemberRun>>& runs,
           const std::string& plant_report) {
  const auto good =
      static_cast<std::size_t>(std::ranges::count_if(runs, [](const auto& run) { return run->code() == kDone; }));
  const Json plant = Json::parse(plant_report, nullptr, false);
  if (options.json) {
    Json robots = Json::object();
    for (const auto& run : runs) robots[run->name()] = {{"exit_code", *run->code()}, {"summary", run->summary()}};
    const Json all = {{"robots", robots}, {"plant", plant.is_object() ? plant : Json()}, {"good", good}};
    std::printf("%s\n", all.dump().c_str());
  } else {
    for (const auto& run : runs)
      if (const std::string line = radio_line(plant, run->name()); !line.empty()) std::printf("%s\n", line.c_str());
    std::printf("team: %zu of %zu robots did well\n", good, runs.size());
  }
  int worst = kDone;
  for (const auto& run : runs)
    worst = std::max(worst, *run->code() == kNotBegun ? kNotBegun : std::min(*run->code(), kFailed));
  return worst;
}

int run_team(const TeamRunOptions& options, const rt::ModuleTypes& types) {
  static_cast<void>(hal::stop_requested());  // from here on a signal only asks for the end
  const auto setup = set_up_team(options, types);
  if (!setup) return kNotBegun;
  std::string why;
  const auto plant = PlantProcess::open(setup->plant, why);
  if (!plant) return fail(why, hal::stop_requested() ? kFailed : kNotBegun);
  plant->take_stream().reset();  // it was only to see that the plant is there
  std::size_t width = 0;
  for (const TeamMember& m : setup->members) width = std::max(width, m.name.size());
  std::vector<std::unique_ptr<MemberRun>> runs;
  for (const TeamMember& m : setup->members) {
    std::vector<std::string> argv{hal::program_path()};
    argv.insert(argv.end(), m.arguments.begin(), m.arguments.end());
    argv.insert(argv.end(), {"--plant", plant->endpoint()});
    runs.push_back(std::make_unique<MemberRun>(m.name, width, !options.json));
    if (!runs.back()->start(argv)) return kNotBegun;  // the others end with this process's objects
  }
  watch(runs);
  why = plant->wait_for_end(hal::stop_requested() ? 1s : 3s);
  if (const auto exit = plant->ended(0s); why.empty() && exit && exit->code > 128)
    why = "the simulator " + to_string(*exit);
  if (!why.empty() && !hal::stop_requested()) std::fprintf(stderr, "sinew: %s\n", why.c_str());
  return report(options, runs, plant->last_report());
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
