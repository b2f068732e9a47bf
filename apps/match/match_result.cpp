#include "apps/match/match_result.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "apps/sweep/case_text.hpp"
#include "apps/sweep/summary.hpp"
#include "math/hash.hpp"

namespace sinew::app {
namespace {

double number_at(const Json& object, const char* key) {
  const auto it = object.find(key);
  return it != object.end() && it->is_number() ? it->get<double>() : 0;
}

std::uint64_t count_at(const Json& object, const char* key) {
  return static_cast<std::uint64_t>(std::max(0.0, number_at(object, key)));
}

std::string text_at(const Json& all, const char* pointer) {
  const Json::json_pointer at(pointer);
  return all.is_object() && all.contains(at) && all[at].is_string() ? all[at].get<std::string>() : std::string();
}

const char* colour(unsigned c) { return c == 0 ? "blue" : "red"; }

PlayerResult player_result(const Player& player, const Json& report, const MemberEnd* end) {
  PlayerResult r;
  r.player = player;
  r.falls = count_at(report, "falls");
  r.rises = count_at(report, "rises");
  r.kicks = count_at(report, "kicks");
  r.penalties = count_at(report, "penalties");
  r.walked_m = number_at(report, "walked_m");
  r.ball_s = number_at(report, "ball_s");
  r.longest_down_s = number_at(report, "longest_down_s");
  if (!end) return r;
  r.exit_code = end->code;
  r.recording = text_at(end->summary, "/recording/path");
  if (end->summary.is_object() && end->summary.contains("hashes"))
    r.hash = fmt::format("{:016x}", math::fnv1a64(end->summary["hashes"].dump()));
  return r;
}

void read_game(const Json& game, const std::vector<Player>& players, MatchResult& result) {
  const auto team_of = [&](unsigned c) {
    const auto one = std::ranges::find(players, c, &Player::colour);
    return one == players.end() ? 0u : one->team;
  };
  result.goals[team_of(0)] = count_at(game, "goals_of_blue");
  result.goals[team_of(1)] = count_at(game, "goals_of_red");
  if (const auto goals = game.find("goals"); goals != game.end() && goals->is_array())
    for (const Json& g : *goals)
      result.goal.push_back({number_at(g, "at_s"), team_of(static_cast<unsigned>(number_at(g, "team"))),
                             static_cast<int>(number_at(g, "robot"))});
  if (const auto log = game.find("log"); log != game.end() && log->is_array())
    for (const Json& line : *log)
      if (line.is_string()) result.log.push_back(line.get<std::string>());
  if (text_at(game, "/state") != "finished" || number_at(game, "half") != 2)
    result.trouble = "the game was not played to its end";
}

}  // namespace

std::string team_name(const MatchOptions& options, unsigned team) {
  return std::filesystem::path(options.teams[team]).stem().string();
}

MatchResult match_result(const MatchOptions& options, const TeamEnd& end) {
  MatchResult result;
  result.seed = options.seed;
  result.plant = end.plant;
  const std::vector<Player> players = players_of(options);
  const auto robots = end.plant.is_object() ? end.plant.find("robots") : end.plant.end();
  Json game;  // of the player that saw the game last: a run that ended earlier has an older report
  double game_at_s = -1;
  for (const Player& player : players) {
    Json report = Json::object();
    if (end.plant.is_object() && robots != end.plant.end() && robots->contains(player.name))
      report = (*robots)[player.name];
    const auto member = std::ranges::find(end.members, player.name, &MemberEnd::name);
    result.players.push_back(player_result(player, report, member == end.members.end() ? nullptr : &*member));
    const double plant_s = number_at(report, "plant_s");
    result.plant_s = std::max(result.plant_s, plant_s);
    if (report.contains("game") && plant_s > game_at_s) game = report["game"], game_at_s = plant_s;
  }
  if (!game.is_null()) read_game(game, players, result);
  if (!result.trouble.empty())
    result.trouble +=
        fmt::format(": the last player's run ended after {:.1f} s (a mission that is done ends a run)", result.plant_s);
  if (game.is_null()) result.trouble = "the simulator reported no game";
  for (const PlayerResult& p : result.players)
    if (p.exit_code > kFailed) result.trouble = fmt::format("{} ended with exit code {}", p.player.name, p.exit_code);
  result.finished = result.trouble.empty();
  return result;
}

std::string to_text(const MatchOptions& options, const MatchResult& result) {
  const auto side = [&](unsigned team) {
    return fmt::format("{} {} ({})", team == 0 ? "A" : "B", team_name(options, team),
                       colour(a_is_blue(result.seed) == (team == 0) ? 0 : 1));
  };
  std::string text =
      fmt::format("{}  {} : {}  {}    {} on {}, {:g} min, seed {}\n", side(0), result.goals[0], result.goals[1],
                  side(1), options.robots, options.robots, options.minutes, result.seed);
  if (!result.finished) text += "not finished: " + result.trouble + "\n";
  for (const Goal& goal : result.goal) {
    const bool known = goal.player >= 0 && static_cast<std::size_t>(goal.player) < result.players.size();
    const PlayerResult* const by = known ? &result.players[static_cast<std::size_t>(goal.player)] : nullptr;
    text += fmt::format(
        "  {:7.1f} s  goal for {}{}\n", goal.at_s, goal.team == 0 ? "A" : "B",
        by ? fmt::format(", {}{}", by->player.name, by->player.team == goal.team ? "" : " (own goal)") : std::string());
  }
  std::vector<std::vector<std::string>> rows{
      {"player", "team", "walked m", "kicks", "at the ball s", "falls", "rises", "longest down s", "penalties"}};
  for (const PlayerResult& p : result.players)
    rows.push_back({p.player.name, p.player.team == 0 ? "A" : "B", fmt::format("{:.1f}", p.walked_m),
                    std::to_string(p.kicks), fmt::format("{:.1f}", p.ball_s), std::to_string(p.falls),
                    std::to_string(p.rises), fmt::format("{:.1f}", p.longest_down_s), std::to_string(p.penalties)});
  return text + sweep::table_text(rows, "<<>>>>>>>");
}

sweep::CaseResult to_case(const MatchOptions& options, const MatchResult& result) {
  sweep::CaseResult r;
  r.run = "match " + sweep::joined(words_of(options));
  r.code = result.finished ? kDone : kFailed;
  r.good = result.finished;
  r.outcome = !result.finished                     ? "not finished"
              : result.goals[0] == result.goals[1] ? "drawn"
              : result.goals[0] > result.goals[1]  ? "A won"
                                                   : "B won";
  r.why = result.trouble;
  const auto measure = [&](const std::string& name, double value) { r.measures.push_back({name, value, {}}); };
  measure("goals_a", static_cast<double>(result.goals[0]));
  measure("goals_b", static_cast<double>(result.goals[1]));
  measure("goal_difference", static_cast<double>(result.goals[0]) - static_cast<double>(result.goals[1]));
  for (unsigned team = 0; team < 2; ++team) {
    double falls = 0, rises = 0, kicks = 0, penalties = 0, walked_m = 0, ball_s = 0;
    for (const PlayerResult& p : result.players) {
      if (p.player.team != team) continue;
      falls += static_cast<double>(p.falls), rises += static_cast<double>(p.rises);
      kicks += static_cast<double>(p.kicks), penalties += static_cast<double>(p.penalties);
      walked_m += p.walked_m, ball_s += p.ball_s;
    }
    const std::string end = team == 0 ? "_a" : "_b";
    for (const auto& [name, value] :
         {std::pair("falls", falls), std::pair("rises", rises), std::pair("kicks", kicks),
          std::pair("penalties", penalties), std::pair("walked_m", walked_m), std::pair("ball_s", ball_s)})
      measure(name + end, value);
  }
  std::string all;
  for (const PlayerResult& p : result.players) all += p.hash;
  r.hash = fmt::format("{:016x}", math::fnv1a64(all + result.plant.dump()));
  Json goals = Json::array(), players = Json::object();
  for (const Goal& g : result.goal)
    goals.push_back({{"at_s", g.at_s}, {"team", g.team == 0 ? "A" : "B"}, {"robot", g.player}});
  for (const PlayerResult& p : result.players)
    players[p.player.name] = {{"team", p.player.team == 0 ? "A" : "B"},
                              {"falls", p.falls},
                              {"rises", p.rises},
                              {"kicks", p.kicks},
                              {"penalties", p.penalties},
                              {"walked_m", p.walked_m},
                              {"ball_s", p.ball_s},
                              {"longest_down_s", p.longest_down_s},
                              {"hash", p.hash}};
  r.report = {
      {"a_is_blue", a_is_blue(result.seed)}, {"goals", goals}, {"players", players}, {"plant_s", result.plant_s}};
  return r;
}

}  // namespace sinew::app
