#include "apps/match/players.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "rt/graph_check.hpp"
#include "sim_hil/worlds/fault.hpp"

namespace sinew::app {
namespace {

constexpr rt::Duration kFast = std::chrono::milliseconds(10);
constexpr std::string_view kReport = "report:";
constexpr double kLie_m = 3, kForGood_s = 1e6;

std::vector<std::string> modules_with(const rt::Graph& graph, std::string_view param) {
  std::vector<std::string> names;
  for (const rt::GraphModule& m : graph.modules())
    if (std::ranges::any_of(m.declaration.params, [&](const auto& p) { return p.name == param; }))
      names.push_back(m.spec.name);
  return names;
}

/// Where it comes in when the game begins: on its own half, inside of a touch line, one of two opposite the other.
/// Blue's; red stands as blue does, turned by half a turn around the middle.
struct StartPlace {
  double x_m, y_m, heading_deg;
};
StartPlace place_of(unsigned number, unsigned colour) {
  constexpr double kFirst_m = -1.2, kApart_m = 1, kAside_m = 2.6;
  const unsigned pair = (number - 1) / 2;
  const bool left = number % 2 == 1;
  StartPlace place{kFirst_m - kApart_m * pair, left ? kAside_m : -kAside_m, left ? -90.0 : 90.0};
  if (colour == 1) place = {-place.x_m, -place.y_m, -place.heading_deg};
  return place;
}

bool is_periodic_and_fast(const rt::ThreadSpec& thread) {
  return thread.trigger == rt::ThreadSpec::Trigger::period && thread.period <= kFast;
}

bool is_fast(const rt::GraphSpec& graph, const rt::ThreadSpec& thread) {
  if (thread.trigger != rt::ThreadSpec::Trigger::topics) return is_periodic_and_fast(thread);
  return std::ranges::any_of(thread.topics, [&](const auto& topic) {
    const std::string module(rt::split_topic(topic.value).first);
    return std::ranges::any_of(graph.threads, [&](const rt::ThreadSpec& other) {
      const auto is_it = [&](const auto& m) { return m.value == module; };
      return is_periodic_and_fast(other) && std::ranges::any_of(other.order, is_it);
    });
  });
}

}  // namespace

std::vector<std::string> words_of(const MatchOptions& options, bool with_seed) {
  std::vector<std::string> words{options.teams[0], options.teams[1],
                                 "--robots",       std::to_string(options.robots),
                                 "--minutes",      fmt::format("{}", options.minutes)};
  for (const std::string& setting : options.set) words.insert(words.end(), {"--set", setting});
  for (const std::string& fault : options.faults) words.insert(words.end(), {"--fault", fault});
  if (!options.camera.empty()) words.insert(words.end(), {"--camera", options.camera});
  if (with_seed) words.insert(words.end(), {"--seed", std::to_string(options.seed)});
  return words;
}

std::vector<Player> players_of(const MatchOptions& options) {
  std::vector<Player> players;
  for (unsigned colour = 0; colour < 2; ++colour)
    for (unsigned number = 1; number <= options.robots; ++number) {
      const unsigned team = (colour == 0) == a_is_blue(options.seed) ? 0 : 1;
      players.push_back({fmt::format("{}{}", colour == 0 ? "blue" : "red", number), team, colour, number});
    }
  return players;
}

std::vector<std::string> slow_threads(const rt::GraphSpec& graph) {
  std::vector<std::string> slow;
  for (const rt::ThreadSpec& thread : graph.threads)
    if (!is_fast(graph, thread)) slow.push_back(thread.name);
  return slow;
}

std::vector<std::string> numbered_modules(const rt::Graph& graph) { return modules_with(graph, "player"); }

std::vector<std::string> reporting_modules(const rt::Graph& graph) { return modules_with(graph, "lie_m"); }

bool is_lie(std::string_view fault) { return fault.starts_with(kReport); }

std::vector<std::string> lie_settings(const std::string& fault, const std::string& module, std::string& why) {
  // The form of a fault of a device whose amount is metres, too.
  constexpr std::string_view kWrong = "report:wrong", kMetres = "range:wrong";
  if (!fault.starts_with(std::string(kWrong) + "(") && !fault.starts_with(std::string(kWrong) + "@")) {
    why = fmt::format("fault '{}': a report can be wrong and nothing else: report:wrong(3)@60+10", fault);
    return {};
  }
  std::string rest = fault.substr(kWrong.size());
  if (rest.front() == '@') rest = fmt::format("({:g}){}", kLie_m, rest);
  std::string problem;
  const auto parsed = plant::parse_fault(std::string(kMetres) + rest, problem);
  if (!parsed) {
    const std::size_t colon = problem.find("': ");
    why = fmt::format("fault '{}': {}", fault, colon == problem.npos ? problem : problem.substr(colon + 3));
    return {};
  }
  const auto in_s = [](std::int64_t ns) { return static_cast<double>(ns) / 1e9; };
  const double for_s = parsed->until_ns == plant::kNoEnd ? kForGood_s : in_s(parsed->until_ns - parsed->from_ns);
  return {fmt::format("{}.lie_m={}", module, parsed->amount),
          fmt::format("{}.lie_from_s={}", module, in_s(parsed->from_ns)),
          fmt::format("{}.lie_for_s={}", module, for_s)};
}

std::string player_text(const MatchOptions& options, const Player& player, const std::string& base,
                        const RobotFile& loaded, const std::vector<std::string>& numbered) {
  const StartPlace place = place_of(player.number, player.colour);
  std::string text =
      fmt::format("# Player {} of a match; `sinew match` wrote it.\nextends = {}\n", player.name, rt::quoted(base));
  if (loaded.team) text += "without = [\"team.members\"]\n";
  text += fmt::format(
      "\n[robot]\nname = \"{}\"\n\n[sim]\nplant = \"auto\"\nreferee = 1\nreferee_half_s = {}\nteam = {}\n"
      "start_x_m = {}\nstart_y_m = {}\nstart_heading_deg = {}\n",
      player.name, 30 * options.minutes, player.colour, place.x_m, place.y_m, place.heading_deg);
  if (loaded.team) {
    text += fmt::format("\n[team]\nrobot = {}\nteam = {}\n\n[team.members]\n", player.number, player.colour + 1);
    for (const Player& other : players_of(options))
      if (other.colour == player.colour) text += fmt::format("{} = {}\n", other.name, other.number);
  }
  for (const std::string& module : numbered)
    text += fmt::format("\n[module.{}.params]\nplayer = {}\n", module, player.number);
  text += "\n[record]\npixel_mb_per_s = 0\ncompression = \"zstd\"\n";
  if (!options.record_all && loaded.record.threads.empty()) {
    const auto slow = slow_threads(loaded.graph);
    if (!slow.empty()) text += fmt::format("threads = [\"{}\"]\n", fmt::join(slow, "\", \""));
  }
  return text;
}

std::string why_no_player(const RobotFile& robot) {
  if (robot.sim.world != "soccer")
    return fmt::format("its world is {}; a match is played in the world soccer (sim.world)", robot.sim.world);
  const auto hears = [](const rt::ModuleSpec& m) { return m.type == "drivers::RefereeSource"; };
  if (std::ranges::none_of(robot.graph.modules, hears))
    return "it does not hear the referee: a module of the type drivers::RefereeSource is missing (docs/kid.md)";
  return {};
}

}  // namespace sinew::app
