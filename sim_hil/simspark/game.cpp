#include "sim_hil/simspark/game.hpp"

#include <algorithm>

#include "sim_hil/simspark/field.hpp"
#include "sim_hil/simspark/frame.hpp"

namespace sinew::simspark {
namespace {

using math::Vec3;

constexpr std::array<std::string_view, kPlayModes> kNames{
    "BeforeKickOff",    "KickOff_Left",      "KickOff_Right",  "PlayOn",          "KickIn_Left",    "KickIn_Right",
    "corner_kick_left", "corner_kick_right", "goal_kick_left", "goal_kick_right", "offside_left",   "offside_right",
    "GameOver",         "Goal_Left",         "Goal_Right",     "free_kick_left",  "free_kick_right"};

constexpr double kGoalKick_m = 1;  // from the goal line

PlayMode of_team(PlayMode left, Team team) {
  return static_cast<PlayMode>(static_cast<int>(left) + (team == Team::right ? 1 : 0));
}

}  // namespace

std::string_view to_string(Team team) { return team == Team::left ? "left" : "right"; }
std::string_view to_string(PlayMode mode) { return kNames[static_cast<std::size_t>(mode)]; }
std::optional<PlayMode> play_mode_of(std::string_view name) {
  const auto found = std::ranges::find(kNames, name);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<PlayMode>(found - kNames.begin());
}

Vec3 SparkGame::restart(PlayMode left, Team team, Vec3 at_m) {
  mode_ = of_team(left, team);
  in_mode_s_ = 0;
  at_m.z = kSparkBall.radius_m;
  mark_m_ = at_m;
  return at_m;
}

void SparkGame::kick_off(Team team) { restart(PlayMode::kick_off_left, team, {}); }

void SparkGame::set_mode(PlayMode mode, const Vec3& ball_m) {
  mode_ = mode;
  in_mode_s_ = 0;
  mark_m_ = ball_m;
}

std::optional<Vec3> SparkGame::end_half() {
  if (half_ == 2) {
    mode_ = PlayMode::game_over;
    return std::nullopt;
  }
  half_ = 2;
  return restart(PlayMode::kick_off_left, Team::right, {});
}

std::optional<Vec3> SparkGame::judge(const Vec3& ball, std::optional<Team> touched) {
  const double x = kSparkField.length_m / 2, y = kSparkField.width_m / 2, r = kSparkBall.radius_m;
  const Team side = ball.x > 0 ? Team::right : Team::left;  // whose goal line is near
  if (math::fabs(ball.x) > x + r) {
    if (math::fabs(ball.y) < kSparkField.goal_width_m / 2 && ball.z < kSparkField.goal_height_m) {
      ++score_[index(other(side))];
      mode_ = of_team(PlayMode::goal_left, other(side));
      in_mode_s_ = 0;
      return std::nullopt;
    }
    const double sign = side == Team::right ? 1 : -1;
    if (touched == side) return restart(PlayMode::corner_kick_left, other(side), {sign * x, ball.y > 0 ? y : -y, 0});
    return restart(PlayMode::goal_kick_left, side, {sign * (x - kGoalKick_m), 0, 0});
  }
  if (math::fabs(ball.y) > y + r)
    return restart(PlayMode::kick_in_left, touched ? other(*touched) : Team::left,
                   {std::clamp(ball.x, -x, x), ball.y > 0 ? y : -y, 0});
  return std::nullopt;
}

std::optional<Vec3> SparkGame::step(const Vec3& ball, std::optional<Team> touched) {
  if (mode_ == PlayMode::game_over) return std::nullopt;
  if (mode_ == PlayMode::before_kick_off) {
    waited_s_ += kCycle_s;
    if (rules_.kick_off_after_s <= 0 || waited_s_ < rules_.kick_off_after_s) return std::nullopt;
    return restart(PlayMode::kick_off_left, Team::left, {});
  }
  time_s_ += kCycle_s;
  in_mode_s_ += kCycle_s;
  if (time_s_ >= rules_.half_s * half_) return end_half();
  switch (mode_) {
    case PlayMode::play_on:
      return judge(ball, touched);
    case PlayMode::goal_left:
    case PlayMode::goal_right:
      if (in_mode_s_ < rules_.goal_pause_s) return std::nullopt;
      return restart(PlayMode::kick_off_left, mode_ == PlayMode::goal_left ? Team::right : Team::left, {});
    default:
      break;
  }
  if (math::hypot(ball.x - mark_m_.x, ball.y - mark_m_.y) > rules_.moved_m || in_mode_s_ >= rules_.drop_ball_s)
    set_mode(PlayMode::play_on, ball);
  return std::nullopt;
}

}  // namespace sinew::simspark
