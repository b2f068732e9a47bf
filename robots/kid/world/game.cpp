#include "robots/kid/world/game.hpp"

#include <algorithm>
#include <cstdio>

#include "sim_hil/worlds/json_object.hpp"

namespace sinew::plant {
namespace {

constexpr std::size_t kReported = 200;  // decisions, the newest; a report has at most 60 KiB

// Both lists are in the order of RoboCup's protocol.
static_assert(static_cast<int>(msg::GamePhase::finished) == static_cast<int>(GameState::finished));
static_assert(static_cast<int>(msg::GamePenalty::picked_up) == static_cast<int>(Penalty::picked_up));

}  // namespace

Game::Game(const RefereeRules& rules, std::span<const std::uint8_t> teams)
    : referee_(kKidField, kKidBall, rules, teams), teams_(teams.begin(), teams.end()), seen_(teams.size()) {
  moved_.reserve(teams.size());
  referee_.start(0);
}

RefereeRules Game::rules_of(const WorldInfo& info, const WorldValues& values) {
  const auto value = [&](const char* key) { return info.value(values, key).value(); };
  RefereeRules rules;
  rules.ready_s = value("referee_ready_s");
  rules.set_s = value("referee_set_s");
  rules.half_s = value("referee_half_s");
  rules.fallen_s = value("referee_fallen_s");
  rules.penalty_s = value("referee_penalty_s");
  return rules;
}

void Game::look(Pitch& pitch) {
  now_ns_ = pitch.now_ns();
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    const BodyTruth& truth = pitch.truth(i);
    seen_[i] = {truth.torso.p_m.x, truth.torso.p_m.y, truth.fallen};
  }
  const Referee::Orders& orders = referee_.step({pitch.ball().p_m, pitch.ball().touched_by, seen_}, now_ns_);
  if (orders.ball) pitch.place_ball(*orders.ball);
  moved_.clear();
  for (std::size_t i = 0; i < orders.moves; ++i) {
    const Referee::Move& move = orders.move[i];
    // As a person puts it down: upright, with its joints where they are.
    PitchPlace at{.x_m = move.x_m, .y_m = move.y_m, .heading_rad = move.heading_rad};
    const auto& joints = pitch.truth(move.robot).joint_rad;
    at.joints_rad.assign(joints.begin(), joints.begin() + static_cast<std::ptrdiff_t>(pitch.body(move.robot).joints()));
    pitch.place(move.robot, at);
    moved_.push_back(move.robot);
  }
  if (referee_.state() == GameState::finished && referee_.half() == 1) referee_.start(now_ns_);
}

msg::RefereeState Game::said_to(std::size_t robot) const {
  const std::uint8_t own = teams_[robot];
  msg::RefereeState said;
  said.left_s = referee_.seconds_left(now_ns_);
  said.penalty_left_s = referee_.penalty_seconds_left(robot, now_ns_);
  said.phase = static_cast<msg::GamePhase>(referee_.state());
  said.penalty = static_cast<msg::GamePenalty>(referee_.penalty(robot));
  if (referee_.kicking_team() >= 0)
    said.kick = referee_.kicking_team() == own ? msg::GameKick::own : msg::GameKick::other;
  said.half = static_cast<std::uint32_t>(referee_.half());
  said.own_goals = static_cast<std::uint32_t>(referee_.score()[own]);
  said.other_goals = static_cast<std::uint32_t>(referee_.score()[1 - own]);
  said.team = own;
  said.attacks_right = referee_.side(own) < 0 ? 1 : 0;
  return said;
}

std::uint32_t Game::penalties(std::size_t robot) const {
  return static_cast<std::uint32_t>(std::ranges::count_if(referee_.log(), [&](const Referee::Decision& d) {
    return d.kind == Referee::Decision::Kind::penalty && d.robot == static_cast<int>(robot);
  }));
}

void Game::add_to(JsonObject& report) const {
  JsonObject game;
  game.text("state", std::string(to_string(referee_.state())));
  game.integer("half", static_cast<std::uint64_t>(referee_.half()));
  game.number("left_s", referee_.seconds_left(now_ns_));
  game.integer("goals_of_blue", static_cast<std::uint64_t>(referee_.score()[0]));
  game.integer("goals_of_red", static_cast<std::uint64_t>(referee_.score()[1]));
  game.integer("decisions", decisions());
  std::vector<std::string> goals, log;
  for (const Referee::Decision& d : referee_.log()) {
    if (d.kind != Referee::Decision::Kind::goal || goals.size() == kReported) continue;
    char goal[96];
    std::snprintf(goal, sizeof goal, R"({"at_s":%.3f,"team":%d,"robot":%d})", 1e-9 * static_cast<double>(d.at_ns),
                  d.team, d.robot);
    goals.emplace_back(goal);
  }
  game.list("goals", goals);
  for (const Referee::Decision& d : referee_.log().last(std::min(kReported, decisions())))
    log.push_back('"' + to_string(d) + '"');
  game.list("log", log);
  report.object("game", game.done());
}

}  // namespace sinew::plant
