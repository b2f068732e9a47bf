#include "soccer/baseline/player.hpp"

#include <gtest/gtest.h>

#include "math/random.hpp"
#include "rt/exec/module_rig.hpp"

namespace sinew::soccer::baseline_player_test {
namespace {

using namespace std::chrono_literals;

constexpr double kStep_s = 0.05, kKickBy_m = 0.04, kRolls_m = 1.06;

/// The module in virtual time, on a field on which a robot goes where it wants, and a kick that is well placed moves
/// the ball 0.6 s later.
struct Game {
  PlayBaseline player;
  rt::ModuleRig rig{player};
  Field field;
  FieldAt robot{-1, 0.5, 0};
  FieldPoint ball{0, 0};
  msg::Time now{1'000'000'000};
  bool sees = true;
  msg::RefereeState said;
  msg::GaitMode mode = msg::GaitMode::walk;
  int kicks = 0, missed = 0;
  std::uint32_t asked = 0;
  double speed = 0;

  Game() { said.phase = msg::GamePhase::playing; }
  double now_s() const { return msg::seconds(now); }
  void step() {
    const FieldPoint seen = robot.in(ball.x_m, ball.y_m);
    msg::FieldPose pose;
    pose.stamp = now, pose.found = 1;
    pose.x_m = robot.x_m, pose.y_m = robot.y_m, pose.heading_rad = robot.heading_rad;
    rig.put("field", pose);
    if (sees) {
      msg::BallModel b;
      b.stamp = b.seen = now;
      b.x_m = seen.x_m, b.y_m = seen.y_m, b.confidence = 0.9;
      rig.put("ball", b);
    }
    msg::GaitState gait;
    gait.stamp = now, gait.mode = mode;
    gait.request = asked;
    gait.progress = asked != 0 ? msg::RequestProgress::done : msg::RequestProgress::none;
    rig.put("gait", gait);
    said.stamp = now;
    rig.put("referee", said);
    ASSERT_EQ(rig.step(now + 10ms, 50ms), rt::StepStatus::ok);
    if (const auto* kick = rig.get<msg::KickRequest>("kick"); kick && kick->id != asked) take(*kick, seen);
    const auto* v = rig.get<msg::VelocityCommand>("velocity");
    ASSERT_NE(v, nullptr);
    speed = math::hypot(v->linear_mps.x, v->linear_mps.y) + math::fabs(v->angular_radps.z);
    robot = robot.then({kStep_s * v->linear_mps.x, kStep_s * v->linear_mps.y, kStep_s * v->angular_radps.z});
    now = now + 50ms;
  }
  void take(const msg::KickRequest& kick, const FieldPoint& seen) {
    asked = kick.id;
    ++kicks;
    EXPECT_EQ(kick.motion, msg::BallMotion::kick_forward);
    const double side = kick.foot == msg::Foot::left ? 1 : -1;
    if (length_m(seen - FieldPoint{0.19, side * 0.05}) > kKickBy_m) {
      ++missed;
      return;
    }
    ball = FieldAt{ball.x_m, ball.y_m, robot.heading_rad}.out(kRolls_m, 0);
  }
  bool scored() const {
    return ball.x_m > 0.5 * field.size().length_m && math::fabs(ball.y_m) < 0.5 * field.size().goal_width_m;
  }
};

TEST(BaselinePlayer, WalksToTheBallAndKicksItIntoTheOtherGoalFromAnywhere) {
  math::Random random(1);
  for (int n = 0; n < 20; ++n) {
    Game game;
    game.robot = {random.uniform(-4, 4), random.uniform(-2.5, 2.5), random.uniform(-3, 3)};
    game.ball = {random.uniform(-3.5, 3.5), random.uniform(-2.5, 2.5)};
    while (!game.scored() && game.now_s() < 180) game.step();
    EXPECT_TRUE(game.scored()) << "game " << n << ", ball at " << game.ball.x_m << ' ' << game.ball.y_m << ", "
                               << game.kicks << " kicks";
    EXPECT_EQ(game.missed, 0) << "of " << game.kicks;
  }
}

TEST(BaselinePlayer, TurnsToFindABallThatItDoesNotSee) {
  Game game;
  game.sees = false;
  double turned_rad = 0;
  for (int i = 0; i < 240; ++i) {
    const double before = game.robot.heading_rad;
    game.step();
    turned_rad += math::fabs(math::wrap_pi(game.robot.heading_rad - before));
  }
  EXPECT_GT(turned_rad, 5);
  EXPECT_EQ(game.kicks, 0);
}

TEST(BaselinePlayer, StandsInSetWhilePenalisedAndLying) {
  for (int n = 0; n < 3; ++n) {
    Game game;
    if (n == 0) game.said.phase = msg::GamePhase::set;
    if (n == 1) game.said.penalty = msg::GamePenalty::incapable;
    if (n == 2) game.mode = msg::GaitMode::lie;
    for (int i = 0; i < 40; ++i) {
      game.step();
      EXPECT_EQ(game.speed, 0) << n;
    }
    game.said.phase = msg::GamePhase::playing, game.said.penalty = msg::GamePenalty::none;
    game.mode = msg::GaitMode::walk;
    game.step();
    EXPECT_GT(game.speed, 0) << n;
  }
}

TEST(BaselinePlayer, LeavesTheBallToTheOthersForTheirKickOffUntilItMoves) {
  Game game;
  game.robot = {-1.3, 0, 0};
  game.said.phase = msg::GamePhase::set;
  game.step();
  game.said.phase = msg::GamePhase::playing;
  game.said.kick = msg::GameKick::other;
  for (int i = 0; i < 100; ++i) game.step();
  EXPECT_LT(distance_m(game.robot, {-1.3, 0, 0}), 0.01);
  game.ball = {0.5, 0.3};
  for (int i = 0; i < 20; ++i) game.step();
  EXPECT_GT(distance_m(game.robot, {-1.3, 0, 0}), 0.05);
}

TEST(BaselinePlayer, StandsOutsideOfTheCircleBeforeAKickOffThatIsNotKnownToBeItsOwn) {
  Game game;
  game.said.phase = msg::GamePhase::ready;
  for (int i = 0; i < 600; ++i) game.step();
  EXPECT_GT(math::hypot(game.robot.x_m, game.robot.y_m), game.field.size().circle_radius_m + 0.1);
  EXPECT_LT(game.robot.x_m, 0);
  game.said.kick = msg::GameKick::own;
  for (int i = 0; i < 600; ++i) game.step();
  EXPECT_LT(distance_m(game.robot, {-0.45, 0, 0}), 0.05);
}

TEST(BaselinePlayer, GoesRoundAnotherRobotOnItsWay) {
  Game game;
  game.robot = {-2, 0, 0};
  game.ball = {1, 0};
  const FieldPoint other{-0.7, 0.05};
  double nearest_m = math::kInf;
  for (int i = 0; i < 600 && game.kicks == 0; ++i) {
    msg::ObstacleModel seen;
    seen.stamp = game.now;
    seen.obstacles = 1;
    const FieldPoint at = game.robot.in(other.x_m, other.y_m);
    seen.obstacle[0].x_m = at.x_m, seen.obstacle[0].y_m = at.y_m, seen.obstacle[0].radius_m = 0.15;
    game.rig.put("obstacles", seen);
    game.step();
    nearest_m = std::min(nearest_m, length_m(FieldPoint{game.robot.x_m, game.robot.y_m} - other));
  }
  EXPECT_EQ(game.kicks, 1);
  EXPECT_GT(nearest_m, 0.25);
}

}  // namespace
}  // namespace sinew::soccer::baseline_player_test
