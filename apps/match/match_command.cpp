#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "apps/command/number_check.hpp"
#include "apps/match/commands.hpp"
#include "apps/match/match_run.hpp"
#include "apps/match/match_study.hpp"
#include "hal/linux/process.hpp"

namespace sinew::app {
namespace {

struct MatchCommand {
  MatchOptions match{};
  std::vector<std::string> teams{};
  std::string replay{};
};

int play_one(const MatchOptions& options, const rt::ModuleTypes& types) {
  static_cast<void>(hal::stop_requested());  // from here on a signal only asks for the end
  const auto played = play_match(options, types);
  if (!played) return hal::stop_requested() ? kFailed : kNotBegun;
  const MatchResult& result = played->result;
  if (options.json) {
    std::printf("%s", to_line(sweep::to_json(to_case(options, result))).c_str());
  } else {
    std::printf("%s", to_text(options, result).c_str());
    std::printf("%.1f s in %.1f s\n", result.plant_s, played->wall_s);
    if (!played->folder.empty())
      std::printf("recorded  %s, %.1f MB; `sinew match --replay %s` executes it again\n", played->folder.c_str(),
                  1e-6 * static_cast<double>(played->recorded_bytes), played->folder.c_str());
  }
  return result.finished ? kDone : kFailed;
}

int run(MatchCommand& command, const rt::ModuleTypes& types) {
  MatchOptions& o = command.match;
  if (!command.replay.empty()) {
    if (!command.teams.empty()) return fail("--replay: executes a recorded match again; it takes no robot files");
    static_cast<void>(hal::stop_requested());
    return replay_match(command.replay, o.json);
  }
  if (command.teams.size() != 2)
    return fail(fmt::format("two robot files, one for each team; {} given", command.teams.size()));
  o.teams = {command.teams[0], command.teams[1]};
  if (o.count == 1 && o.results.empty() && o.shard.empty()) return play_one(o, types);
  if (!o.gamecontroller.empty()) return fail("--gamecontroller: of one match, not of many at a time");
  return run_matches(o, types);
}

void describe(CLI::App& app, MatchCommand& command) {
  MatchOptions& o = command.match;
  app.add_option("teams", command.teams, "robot files of team A and team B, each for all players of it")
      ->expected(0, 2)
      ->type_name(kRobotFileHint);
  app.add_option("--robots", o.robots, "players of each team (default: 2)")->check(whole(1, 4))->type_name("N");
  app.add_option("--minutes", o.minutes, "playing time of both halves together (default: 10)")
      ->check(number(0.05, 60))
      ->type_name("M");
  app.add_option("--seed", o.seed, "of the first match (default: 1); A is blue in matches with an odd seed")
      ->check(whole())
      ->type_name("N");
  app.add_option("--count", o.count, "matches, with the seeds from --seed on (default: 1)")
      ->check(whole(1, 1'000'000))
      ->type_name("M");
  app.add_option(
         "--set", o.set,
         "[WHO/]KEY=VALUE as `run --set` has it; WHO is a, b or a player such as blue1, else all; may be repeated")
      ->allow_extra_args(false)
      ->type_name(kSettingHint);
  app.add_option(
         "--fault", o.faults,
         "[WHO/]FAULT: of a device, e.g. blue1/camera:off@60+5, which the simulator plays; link:closed, it dies; "
         "report:wrong(3)@60+10, it tells its mates of a ball 3 m beside where it is; may be repeated")
      ->allow_extra_args(false)
      ->type_name("FAULT");
  app.add_option("--gamecontroller", o.gamecontroller,
                 "address that hears the referee as RoboCup's game controller, 127.0.0.1:3838; may be repeated")
      ->allow_extra_args(false)
      ->type_name("ADDRESS:PORT");
  app.add_option("--camera", o.camera, "size of the cameras' frames")->type_name("WxH");
  app.add_option("--out", o.out,
                 "folder of the recording (default: matches/A-B-SEED); of many matches the folder of their folders")
      ->type_name(kFolderHint);
  CLI::Option& none = *app.add_flag("--no-record", o.no_record, "no recordings");
  app.add_flag("--record-all", o.record_all, "record the steps of fast threads, too (about 1 GB in 10 min of 2 on 2)")
      ->excludes(&none);
  app.add_option("--pixels", o.pixels_s,
                 "FROM,UNTIL: also the pictures of all cameras in this part of the match, s of the world, as files")
      ->delimiter(',')
      ->expected(2)
      ->excludes(&none)
      ->type_name("FROM,UNTIL");
  app.add_flag("--no-goal-pictures", o.no_goal_pictures, "do not draw the goals");
  app.add_option("--jobs", o.jobs, "matches at a time (default: one for each processor)")
      ->check(whole(0, 4096))
      ->type_name("N");
  app.add_option("--patience", o.patience_s, "real time after which a match hangs, and is ended (default: 7200)")
      ->check(number(0.1))
      ->type_name("S");
  app.add_option("--results", o.results, "file of results of many matches (default: one of their own, beside them)")
      ->type_name(kFileHint);
  app.add_option("--shard", o.shard, "only part I of N, as 2/5; `sinew merge` puts the parts together")
      ->type_name("I/N");
  app.add_option("--replay", command.replay,
                 "execute a recorded match again: draws all pictures from its scenes, compares their hashes and what "
                 "comes out of each recorded step")
      ->type_name(kFolderHint);
  app.add_flag("--json", o.json, "the result as one JSON object");
}

}  // namespace

void add_match_command(CLI::App& app, CommandContext& context) {
  const auto command = std::make_shared<MatchCommand>();
  CLI::App& match = *app.add_subcommand("match", "play soccer matches of two teams in the simulator, and sum them up");
  describe(match, *command);
  match.callback(
      [&context, command] { context.action = [&types = context.types, command] { return run(*command, types); }; });
}

}  // namespace sinew::app
