#pragma once
// Play modes, score and time of a game of RoboCup's 3D soccer simulation: as much of its rules as a game needs to go
// on. Pure: it sees the ball, and says where it shall be put.
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "math/linear.hpp"

namespace sinew::simspark {

enum class Team : std::uint8_t { left, right };
constexpr std::size_t index(Team team) { return static_cast<std::size_t>(team); }
constexpr Team other(Team team) { return team == Team::left ? Team::right : Team::left; }
/// "left", "right".
std::string_view to_string(Team team);

/// In the order of rcssserver3d's list, which monitors count by.
enum class PlayMode : std::uint8_t {
  before_kick_off,
  kick_off_left,
  kick_off_right,
  play_on,
  kick_in_left,
  kick_in_right,
  corner_kick_left,
  corner_kick_right,
  goal_kick_left,
  goal_kick_right,
  offside_left,
  offside_right,
  game_over,
  goal_left,
  goal_right,
  free_kick_left,
  free_kick_right,
};
/// "BeforeKickOff", "corner_kick_left", as percepts have it.
std::string_view to_string(PlayMode mode);
std::optional<PlayMode> play_mode_of(std::string_view name);
inline constexpr std::size_t kPlayModes = 17;

/// Source:  rcssserver3d, naosoccersim.rb.
struct GameRules {
  double half_s = 300, goal_pause_s = 3, drop_ball_s = 15;
  double kick_off_after_s = 0;  // of the server's time, by itself; 0: a monitor says when
  double moved_m = 0.05;        // a ball that went that far is in play
};

class SparkGame {
 public:
  explicit SparkGame(const GameRules& rules) : rules_(rules) {}

  /// Each cycle. `touched`: whose player touched the ball last. The ball is put there, at rest, when the answer has a
  /// place.
  std::optional<math::Vec3> step(const math::Vec3& ball_m, std::optional<Team> touched);
  /// What a monitor orders.
  void kick_off(Team team);
  void set_mode(PlayMode mode, const math::Vec3& ball_m);
  void set_score(int left, int right) { score_ = {left, right}; }
  void set_time(double time_s) { time_s_ = time_s; }
  void moved(const math::Vec3& ball_m) { mark_m_ = ball_m; }

  PlayMode mode() const { return mode_; }
  double time_s() const { return time_s_; }
  int half() const { return half_; }
  int score(Team team) const { return score_[index(team)]; }
  bool may_beam() const {
    return mode_ == PlayMode::before_kick_off || mode_ == PlayMode::goal_left || mode_ == PlayMode::goal_right;
  }

 private:
  math::Vec3 restart(PlayMode left, Team team, math::Vec3 at_m);
  std::optional<math::Vec3> judge(const math::Vec3& ball_m, std::optional<Team> touched);
  std::optional<math::Vec3> end_half();

  GameRules rules_;
  PlayMode mode_ = PlayMode::before_kick_off;
  double time_s_ = 0, waited_s_ = 0, in_mode_s_ = 0;
  int half_ = 1;
  std::array<int, 2> score_{};
  math::Vec3 mark_m_;  // where the ball lay when the mode began
};

}  // namespace sinew::simspark
