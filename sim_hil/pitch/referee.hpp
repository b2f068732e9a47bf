#pragma once
// The referee of a game on the pitch: kick-off, goals, out, robots that stay down, penalties; the states of RoboCup's
// game controller; and a log of what was decided. Pure: it sees positions, and says what the world shall move.
//
//   Referee referee(kKidField, kKidBall, {}, teams);      // one team number for each robot
//   referee.start(now_ns);
//   const Referee::Orders& orders = referee.step(seen, now_ns);
//   if (orders.ball) pitch.place_ball(*orders.ball);
//
// Frames:  the field's; in the first half team 0 has its goal at -x.
// Source:  RoboCup Soccer Humanoid League, Laws of the Game (Laws 7 to 12); states as in the RoboCup game controller's
//          protocol. What it does not judge: docs/pitch.md.
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "math/linear.hpp"
#include "sim_hil/pitch/field.hpp"

namespace sinew::plant {

enum class GameState : std::uint8_t { initial, ready, set, playing, finished };
std::string_view to_string(GameState state);

enum class Penalty : std::uint8_t {
  none,
  illegal_position,  // not in its half at "set", or at the ball before it may
  incapable,         // stayed down too long
  left_field,        // beyond the carpet
  pushing,           // this and what follows: a human referee's
  ball_holding,
  picked_up,
};
std::string_view to_string(Penalty penalty);

struct RefereeRules {
  double half_s = 600, ready_s = 45, set_s = 5;
  double kick_off_s = 10;  // so long the other team keeps away from the ball, unless it moves before
  double fallen_s = 20;    // a robot that is down for longer is incapable
  double penalty_s = 30;
  double moved_m = 0.05;  // a ball that went that far was kicked off
};

class Referee {
 public:
  static constexpr std::size_t kMostRobots = 22;

  struct SeenRobot {
    double x_m = 0, y_m = 0;
    bool fallen = false;
  };
  struct Seen {
    math::Vec3 ball_m;
    int touched_by = -1;  // the robot that touched the ball last; -1: none
    std::span<const SeenRobot> robots{};
  };
  /// Somebody is put upright at a place.
  struct Move {
    std::size_t robot = 0;
    double x_m = 0, y_m = 0, heading_rad = 0;
  };
  /// What the world shall do now; valid until the next call.
  struct Orders {
    std::optional<math::Vec3> ball{};  // put there, at rest
    std::array<Move, kMostRobots> move{};
    std::size_t moves = 0;
  };
  struct Decision {
    enum class Kind : std::uint8_t { state, kick_off, goal, throw_in, goal_kick, corner_kick, penalty, back } kind{};
    std::int64_t at_ns = 0;
    int team = -1, robot = -1;  // -1: no one's
    GameState state{};
    Penalty penalty{};
    std::array<int, 2> score{};
  };

  /// At most kMostRobots; teams are 0 and 1.
  Referee(const FieldSize& field, const BallSize& ball, const RefereeRules& rules, std::span<const std::uint8_t> teams,
          std::uint8_t first_kick_off = 0);

  /// From initial, or from finished into the next half, in which sides and kick-off change.
  void start(std::int64_t now_ns);
  /// At any rate; `seen` has a place for each robot.
  const Orders& step(const Seen& seen, std::int64_t now_ns);
  /// What a human referee decides. Its order is in the next step's.
  void penalise(std::size_t robot, Penalty penalty, std::int64_t now_ns);

  GameState state() const { return state_; }
  std::array<int, 2> score() const { return score_; }
  int half() const { return half_; }
  /// The team that kicks off, throws in or has the kick; -1: nobody has to wait.
  int kicking_team() const { return kicking_team_; }
  Penalty penalty(std::size_t robot) const { return robot_[robot].penalty; }
  /// Until it may come back; 0: it is not penalised.
  double penalty_seconds_left(std::size_t robot, std::int64_t now_ns) const;
  /// -1 or 1: the x side of the goal that a team defends.
  int side(std::uint8_t team) const { return (team == 0) == (half_ % 2 == 1) ? -1 : 1; }
  /// Left in this half.
  double seconds_left(std::int64_t now_ns) const;
  std::span<const Decision> log() const { return log_; }

 private:
  struct Robot {
    std::uint8_t team = 0;
    Penalty penalty = Penalty::none;
    std::int64_t penalty_end_ns = 0;
    std::int64_t down_since_ns = -1;
    bool to_take_out = false;
  };
  void enter(GameState state, std::int64_t now_ns);
  void note(Decision::Kind kind, std::int64_t now_ns, int team, int robot = -1);
  void judge_places(const Seen& seen, std::int64_t now_ns);
  void judge_ball(const Seen& seen, std::int64_t now_ns);
  void judge_robots(const Seen& seen, std::int64_t now_ns);
  void restart(Decision::Kind kind, int team, math::Vec3 at_m, const Seen& seen, std::int64_t now_ns);
  void move_penalised(std::int64_t now_ns);
  void order_move(std::size_t robot, double x_m, double y_m, double heading_rad);
  math::Vec3 free_spot(math::Vec3 at_m, const Seen& seen) const;

  FieldSize field_;
  BallSize ball_;
  RefereeRules rules_;
  std::array<Robot, kMostRobots> robot_{};
  std::size_t robots_ = 0;
  std::uint8_t first_kick_off_;
  GameState state_ = GameState::initial;
  int half_ = 1, kicking_team_ = -1, kick_off_team_ = 0;
  std::array<int, 2> score_{};
  std::int64_t since_ns_ = 0, half_began_ns_ = -1, kick_given_ns_ = 0;
  math::Vec3 ball_given_m_;
  Orders orders_;
  std::vector<Decision> log_;
};

/// "12.3 s: goal for team 1, 0:1".
std::string to_string(const Referee::Decision& decision);

}  // namespace sinew::plant
