#include "apps/match/match_run.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "apps/command/place.hpp"
#include "apps/robot_file/world_options.hpp"
#include "apps/run/run_setup.hpp"
#include "apps/team/team_run.hpp"
#include "hal/linux/process.hpp"
#include "hal/linux/temporary_folder.hpp"
#include "hal/platform.hpp"
#include "robots/robot_kind.hpp"
#include "sim_hil/worlds/fault.hpp"

namespace sinew::app {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr const char* kScenes = "scenes.mcap";
constexpr double kAfterTheEnd_s = 1;  // the players' clocks drift by up to 50 ppm against the world's

std::string default_folder(const MatchOptions& o) {
  return fmt::format("matches/{}-{}-{}", team_name(o, 0), team_name(o, 1), o.seed);
}

bool write_text(const fs::path& path, const std::string& text) {
  std::ofstream out(path, std::ios::binary);
  out << text;
  out.close();
  return out || fail(fmt::format("{}: cannot be written", path.string())) == kDone;
}

/// The robots of both teams as their files have them, checked. Nothing, after saying why.
std::optional<std::array<Prepared, 2>> load_teams(const MatchOptions& o, const rt::ModuleTypes& types) {
  std::vector<Prepared> teams;
  for (const std::string& file : o.teams) {
    RunOptions run;
    run.robot = file;
    run.virtual_time = true;
    run.plant = "auto";
    auto prepared = prepare(run, types);
    if (!prepared) return std::nullopt;
    if (const std::string why = why_no_player(prepared->robot); !why.empty()) {
      fail(fmt::format("{}: {}", file, why));
      return std::nullopt;
    }
    teams.push_back(std::move(*prepared));
  }
  return std::array<Prepared, 2>{std::move(teams[0]), std::move(teams[1])};
}

/// "a/KEY=VALUE" or "a/FAULT" for all players of A, and so on, as `sinew team` takes it.
std::vector<std::string> of_players(const std::vector<std::string>& given, const std::vector<Player>& players) {
  std::vector<std::string> all;
  for (const std::string& setting : given) {
    const bool of_a = setting.starts_with("a/"), of_b = setting.starts_with("b/");
    if (!of_a && !of_b) all.push_back(setting);
    for (const Player& p : players)
      if ((of_a && p.team == 0) || (of_b && p.team == 1)) all.push_back(p.name + setting.substr(1));
  }
  return all;
}

/// The faults that are no device's, as settings of the players that they name; the others go on to the simulator.
/// False, after saying why.
bool lies_to_settings(const std::vector<Player>& players, const std::array<Prepared, 2>& teams, TeamRunOptions& run) {
  std::vector<std::string> devices;
  for (const std::string& fault : run.faults) {
    const std::size_t slash = fault.substr(0, fault.find(':')).find('/');
    const std::string who = slash == fault.npos ? "" : fault.substr(0, slash);
    const std::string what = slash == fault.npos ? fault : fault.substr(slash + 1);
    if (!is_lie(what)) {
      std::string why;
      if (!plant::parse_fault(what, why))
        return fail(fmt::format("--fault: {}{}", why,
                                why.find("device '") == why.npos ? "" : "; of a match also report (docs/match.md)")),
               false;
      devices.push_back(fault);
      continue;
    }
    bool found = false;
    for (const Player& p : players) {
      if (!who.empty() && who != p.name) continue;
      found = true;
      const Prepared& robot = teams[p.team];
      const auto modules = reporting_modules(*robot.graph);
      if (!robot.robot.team || modules.empty())
        return fail(fmt::format("{}: --fault: '{}' is of what it tells its mates, and it tells them nothing: its file "
                                "has no [team] or no module soccer::Team",
                                p.name, what)),
               false;
      std::string why;
      for (const std::string& setting : lie_settings(what, modules.front(), why))
        run.set.push_back(p.name + "/" + setting);
      if (!why.empty()) return fail(fmt::format("--fault: {}", why)), false;
    }
    if (!found) return fail(fmt::format("--fault {}: no player {}", fault, who)), false;
  }
  run.faults = devices;
  return true;
}

/// How long a game lasts, with what comes before each half.
double game_s(const RobotFile& robot) {
  const plant::WorldInfo& world = *robots::find_world(robot.sim.world);
  const auto value = [&](const char* key) { return world.value(robot.sim.options, key).value_or(0); };
  return 2 * (value("referee_ready_s") + value("referee_set_s") + value("referee_half_s"));
}

/// Removes what a match that was broken off left there, and nothing else.
void clear(const fs::path& folder, const std::vector<Player>& players) {
  std::error_code ignored;  // what stays makes the new match say that it cannot write
  fs::remove(folder / kScenes, ignored);
  for (const Player& p : players) {
    for (const char* const ending : {".toml", ".mcap"}) fs::remove(folder / (p.name + ending), ignored);
    fs::remove(folder / "pixels" / (p.name + ".mcap"), ignored);
  }
  std::vector<fs::path> runs;
  for (fs::directory_iterator file(folder, ignored), end; !ignored && file != end; file.increment(ignored))
    for (const Player& p : players)
      if (file->path().filename().string().starts_with(p.name + "-")) runs.push_back(file->path());
  for (const fs::path& run : runs) {
    fs::remove(run / "run.mcap", ignored);
    fs::remove(run, ignored);
  }
}

/// Moves each player's recording into the match's folder, under the player's name.
void gather(const fs::path& folder, MatchResult& result) {
  std::error_code ignored;  // a recording that cannot be moved stays where its player wrote it
  for (PlayerResult& p : result.players) {
    if (p.recording.empty()) continue;
    const fs::path from = p.recording, to = folder / (p.player.name + ".mcap");
    std::error_code moved;
    fs::rename(from, to, moved);
    if (moved) continue;
    p.recording = to.string();
    fs::remove(from.parent_path(), ignored);
  }
  fs::remove(folder / "latest", ignored);
}

std::uint64_t bytes_of(const fs::path& folder) {
  std::uint64_t bytes = 0;
  std::error_code ignored;
  for (fs::directory_iterator file(folder, ignored), end; !ignored && file != end; file.increment(ignored))
    if (file->path().extension() == ".mcap") bytes += file->file_size(ignored);
  return bytes;
}

/// Three pictures of each goal, from beside the half where it was: 1 s, 0.5 s before, and just before it counted.
/// `game`: of both halves, s.
void draw_goals(const fs::path& folder, const MatchOptions& options, const MatchResult& result, double game) {
  const std::string program = find_program("sinew-sim");
  if (program.empty()) return;
  for (const Goal& goal : result.goal) {
    std::vector<std::string> at_s;
    for (const double before_s : {1.0, 0.5, 0.0})
      at_s.push_back(fmt::format("{:.1f}", std::max(0.1, goal.at_s - before_s)));
    const bool is_blue = a_is_blue(options.seed) == (goal.team == 0);
    const int side = is_blue == (goal.at_s <= game / 2) ? 1 : -1;  // blue attacks +x in the first half
    auto child = hal::ChildProcess::start(
        {program, "--redraw", (folder / kScenes).string(), "--png", (folder / "goals").string(),
         "--at=" + fmt::format("{}", fmt::join(at_s, ",")), fmt::format("--eye={},-4.6,2.2", 0.8 * side),
         fmt::format("--target={},0,0.2", 3.4 * side)});
    if (!child || (*child)->wait(300s) != 0) fail("the pictures of a goal could not be drawn");
  }
}

/// The pictures of all cameras in a part of the match, drawn again.
void draw_pixels(const fs::path& folder, const MatchOptions& options) {
  const std::string program = find_program("sinew-sim");
  if (options.pixels_s.size() != 2 || program.empty()) return;
  std::error_code error;
  fs::create_directories(folder / "pixels", error);
  const std::string window = fmt::format("{},{}", options.pixels_s[0], options.pixels_s[1]);
  for (const Player& p : players_of(options)) {
    auto child = hal::ChildProcess::start({program, "--redraw", (folder / kScenes).string(), "--of", p.name, "--window",
                                           window, "--mcap", (folder / "pixels" / (p.name + ".mcap")).string()});
    if (!child || (*child)->wait(300s) != 0) fail(fmt::format("the pictures of {} could not be drawn", p.name));
  }
}

}  // namespace

std::optional<PlayedMatch> play_match(const MatchOptions& options, const rt::ModuleTypes& types) {
  const auto teams = load_teams(options, types);
  if (!teams) return std::nullopt;
  PlayedMatch played;
  std::unique_ptr<hal::TemporaryFolder> temporary;
  fs::path folder;
  if (options.no_record) {
    auto made = hal::TemporaryFolder::make("sinew-match");
    if (!made) return fail("no temporary folder for the players' robot files"), std::nullopt;
    temporary = std::move(*made);
    folder = temporary->path();
  } else {
    folder = options.out.empty() ? default_folder(options) : options.out;
    std::error_code error;
    if (fs::exists(folder / "result.json", error)) {
      fail(fmt::format("{}: a match is recorded there already; --out names another folder", folder.string()));
      return std::nullopt;
    }
    clear(folder, players_of(options));
    fs::create_directories(folder, error);
    if (error) return fail(fmt::format("{}: {}", folder.string(), error.message())), std::nullopt;
  }
  const std::vector<Player> players = players_of(options);
  TeamRunOptions run;
  run.virtual_time = true;
  run.json = true;
  run.seed = options.seed;
  run.camera = options.camera;
  run.set = of_players(options.set, players);
  run.faults = of_players(options.faults, players);
  if (!lies_to_settings(players, *teams, run)) return std::nullopt;
  run.no_record = options.no_record;
  run.record_folder = folder.string();
  for (const Player& p : players) {
    const fs::path file = folder / (p.name + ".toml");
    const std::string base = fs::absolute(options.teams[p.team]).lexically_normal().string();
    if (!write_text(file,
                    player_text(options, p, base, (*teams)[p.team].robot, numbered_modules(*(*teams)[p.team].graph))))
      return std::nullopt;
    run.robots.push_back(file.string());
  }
  if (!options.no_record) run.plant_args = {"--scenes", (folder / kScenes).string()};
  for (const std::string& address : options.gamecontroller) run.plant_args.push_back("--gamecontroller=" + address);
  auto setup = set_up_team(run, types);
  if (!setup) return std::nullopt;
  run.duration_s = game_s(setup->members.front().robot) + kAfterTheEnd_s;
  for (TeamMember& m : setup->members)
    m.arguments.insert(m.arguments.end(), {"--duration", fmt::format("{}", run.duration_s)});
  const hal::Time begin = hal::system_os().now();
  const TeamEnd end = run_members(*setup, run);
  played.wall_s = msg::seconds(hal::system_os().now() - begin);
  if (end.members.empty() || hal::stop_requested()) return std::nullopt;
  played.result = match_result(options, end);
  if (options.no_record) return played;
  played.folder = folder.string();
  gather(folder, played.result);
  if (!options.no_goal_pictures) draw_goals(folder, options, played.result, run.duration_s - kAfterTheEnd_s);
  draw_pixels(folder, options);
  played.recorded_bytes = bytes_of(folder);
  Json all = sweep::to_json(to_case(options, played.result));
  all["log"] = played.result.log;
  if (!write_text(folder / "result.json", all.dump(1) + "\n")) return std::nullopt;
  return played;
}

int replay_match(const std::string& folder, bool json) {
  const fs::path scenes = fs::path(folder) / kScenes;
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator file(folder, error), end; !error && file != end; file.increment(error))
    if (file->path().extension() == ".mcap" && file->path().filename() != kScenes) files.push_back(file->path());
  if (error) return fail(fmt::format("{}: {}", folder, error.message()));
  if (files.empty() || !fs::exists(scenes, error))
    return fail(fmt::format("{}: no recorded match: it has no {} or no player's recording", folder, kScenes));
  std::ranges::sort(files);
  int worst = kDone;
  for (const fs::path& file : files) {
    if (!json) std::printf("%s\n", file.stem().c_str()), std::fflush(stdout);
    std::vector<std::string> argv{hal::program_path(), "replay", file.string(), "--pictures", scenes.string()};
    if (json) argv.emplace_back("--json");
    auto child = hal::ChildProcess::start(argv);
    if (!child) return fail("cannot start sinew replay");
    std::optional<int> code;
    while (!(code = (*child)->wait(200ms)) && !hal::stop_requested()) {
    }
    worst = std::max(worst, code.value_or(kFailed));
    if (hal::stop_requested()) break;
  }
  return worst;
}

}  // namespace sinew::app
