// The referee, on games that are made up.
#include "sim_hil/pitch/referee.hpp"

#include <gtest/gtest.h>

namespace sinew::plant::referee_test {
namespace {

using math::Vec3;
using Kind = Referee::Decision::Kind;

constexpr std::int64_t kTick_ns = 100'000'000;

/// Two robots a team, where their team begins.
struct Game {
  std::vector<std::uint8_t> teams{0, 0, 1, 1};
  Referee referee;
  std::vector<Referee::SeenRobot> robots{{-1, 0.5}, {-3, 0}, {1, 0.5}, {3, 0}};
  Vec3 ball{0, 0, 0.07};
  int touched_by = -1;
  std::int64_t now_ns = 0;
  std::vector<Referee::Move> moves{};

  explicit Game(const RefereeRules& rules = {}) : referee(kKidField, kKidBall, rules, teams) {}
  /// The world obeys.
  void run(double seconds) {
    const std::int64_t end_ns = now_ns + static_cast<std::int64_t>(seconds * 1e9);
    for (; now_ns < end_ns; now_ns += kTick_ns) {
      const Referee::Orders& orders = referee.step({ball, touched_by, robots}, now_ns);
      if (orders.ball) ball = *orders.ball, touched_by = -1;
      for (std::size_t i = 0; i < orders.moves; ++i) {
        moves.push_back(orders.move[i]);
        robots[orders.move[i].robot] = {orders.move[i].x_m, orders.move[i].y_m, false};
      }
    }
  }
  void play() {
    referee.start(now_ns);
    run(45 + 5 + 0.2);
    ASSERT_EQ(referee.state(), GameState::playing);
  }
  int count(Kind kind) const {
    int n = 0;
    for (const auto& d : referee.log()) n += d.kind == kind ? 1 : 0;
    return n;
  }
  const Referee::Decision& last(Kind kind) const {
    for (std::size_t i = referee.log().size(); i-- > 0;)
      if (referee.log()[i].kind == kind) return referee.log()[i];
    ADD_FAILURE() << "no such decision";
    return referee.log()[0];
  }
};

TEST(RefereeOfThePitch, GoesThroughTheStatesOfAHalfAndThenTheOtherHalf) {
  Game game;
  EXPECT_EQ(game.referee.state(), GameState::initial);
  game.run(10);
  EXPECT_EQ(game.referee.state(), GameState::initial) << "it waits for its start";
  game.referee.start(game.now_ns);
  game.run(1);
  EXPECT_EQ(game.referee.state(), GameState::ready);
  game.run(45);
  EXPECT_EQ(game.referee.state(), GameState::set);
  game.run(5);
  EXPECT_EQ(game.referee.state(), GameState::playing);
  EXPECT_EQ(game.referee.kicking_team(), 0);
  EXPECT_EQ(game.referee.side(0), -1);
  game.run(598);
  EXPECT_EQ(game.referee.state(), GameState::playing);
  EXPECT_NEAR(game.referee.seconds_left(game.now_ns), 2, 1.1);
  game.run(3);
  EXPECT_EQ(game.referee.state(), GameState::finished);
  game.robots = {{1, 0.5}, {3, 0}, {-1, 0.5}, {-3, 0}};
  game.referee.start(game.now_ns);
  game.run(51);
  EXPECT_EQ(game.referee.state(), GameState::playing);
  EXPECT_EQ(game.referee.half(), 2);
  EXPECT_EQ(game.referee.side(0), 1) << "sides change";
  EXPECT_EQ(game.referee.kicking_team(), 1) << "and the kick-off";
  EXPECT_EQ(game.count(Kind::penalty), 0);
}

TEST(RefereeOfThePitch, CountsAGoalWhenTheWholeBallIsOverTheLineBetweenThePosts) {
  Game game;
  game.play();
  game.ball = {4.5 + 0.06, 0.5, 0.07}, game.touched_by = 1;
  game.run(0.1);
  EXPECT_EQ(game.referee.score()[0], 0) << "a part of it is still on the line";
  game.ball.x = 4.5 + 0.08;
  game.run(0.1);
  EXPECT_EQ(game.referee.score()[0], 1);
  EXPECT_EQ(game.referee.state(), GameState::ready);
  EXPECT_EQ(game.ball.x, 0) << "the ball is in the middle again";
  EXPECT_EQ(game.last(Kind::goal).robot, 1);
  game.run(51);
  EXPECT_EQ(game.referee.kicking_team(), 1) << "who got the goal kicks off";
  game.ball = {4.6, -0.5, 0.07}, game.touched_by = 3;
  game.run(0.1);
  EXPECT_EQ(game.referee.score()[0], 2) << "an own goal counts for the others";
  EXPECT_EQ(game.referee.score()[1], 0);
  EXPECT_NE(to_string(game.last(Kind::goal)).find(" s: goal for team 0, 2:0"), std::string::npos);
}

TEST(RefereeOfThePitch, OverTheBarAndBesideThePostIsNoGoal) {
  Game game;
  game.play();
  game.ball = {4.6, 0, 1.3}, game.touched_by = 0;
  game.run(0.1);
  game.ball = {4.6, 1.4, 0.07}, game.touched_by = 0;
  game.run(0.1);
  EXPECT_EQ(game.referee.score()[0], 0);
  EXPECT_EQ(game.count(Kind::goal_kick), 2);
  EXPECT_EQ(game.last(Kind::goal_kick).team, 1);
  EXPECT_NEAR(game.ball.x, 3.5, 0.31);
  EXPECT_NEAR(game.ball.y, 1.5, 1e-9);
}

TEST(RefereeOfThePitch, ADefenderThatTouchedItLastGivesACornerAndAnybodyAThrowIn) {
  Game game;
  game.play();
  game.ball = {-4.6, 2, 0.07}, game.touched_by = 0;
  game.run(0.1);
  EXPECT_EQ(game.last(Kind::corner_kick).team, 1);
  EXPECT_EQ(game.ball.x, -4.5);
  EXPECT_EQ(game.ball.y, 3);
  game.ball = {1.25, -3.08, 0.07}, game.touched_by = 2;
  game.run(0.1);
  EXPECT_EQ(game.last(Kind::throw_in).team, 0);
  EXPECT_EQ(game.ball.x, 1.25);
  EXPECT_EQ(game.ball.y, -3);
}

TEST(RefereeOfThePitch, NoBallIsPutOnARobot) {
  Game game;
  game.play();
  game.robots[0] = {1.25, -3.0, false};
  game.ball = {1.25, -3.08, 0.07}, game.touched_by = 2;
  game.run(0.1);
  EXPECT_GT(math::hypot(game.ball.x - 1.25, game.ball.y + 3), 0.24);
}

TEST(RefereeOfThePitch, ARobotThatStaysDownIsTakenOutAndComesBackOverTheTouchLine) {
  Game game;
  game.play();
  game.robots[1].fallen = true;
  game.run(19.5);
  EXPECT_EQ(game.referee.penalty(1), Penalty::none);
  game.robots[1].fallen = false;
  game.run(1);
  game.robots[1].fallen = true;
  game.run(19.5);
  EXPECT_EQ(game.referee.penalty(1), Penalty::none) << "it was up in between";
  game.run(1);
  EXPECT_EQ(game.referee.penalty(1), Penalty::incapable);
  ASSERT_EQ(game.moves.size(), 1u);
  EXPECT_GT(math::fabs(game.moves[0].y_m), 3) << "beside the field";
  EXPECT_LT(game.moves[0].x_m, 0) << "in its half";
  game.run(28);
  EXPECT_EQ(game.moves.size(), 1u);
  game.run(3);
  ASSERT_EQ(game.moves.size(), 2u);
  EXPECT_EQ(math::fabs(game.moves[1].y_m), 3) << "on the touch line";
  EXPECT_EQ(game.referee.penalty(1), Penalty::none);
  EXPECT_EQ(game.count(Kind::back), 1);
}

TEST(RefereeOfThePitch, WhoIsInTheWrongHalfAtSetOrAtTheBallTooEarlyIsPenalised) {
  Game game;
  game.robots[0] = {0.3, 0, false};    // in the other half
  game.robots[2] = {0.5, 0.2, false};  // in the circle, without the kick-off
  game.referee.start(0);
  game.run(45.2);
  EXPECT_EQ(game.referee.penalty(0), Penalty::illegal_position);
  EXPECT_EQ(game.referee.penalty(1), Penalty::none);
  EXPECT_EQ(game.referee.penalty(2), Penalty::illegal_position);
  game.run(5);
  ASSERT_EQ(game.referee.state(), GameState::playing);
  game.ball.x = -0.1, game.touched_by = 3;
  game.run(0.1);
  EXPECT_EQ(game.referee.penalty(3), Penalty::illegal_position) << "it was the other team's kick-off";

  Game late;
  late.play();
  late.run(10);
  late.ball.x = -0.1, late.touched_by = 3;
  late.run(0.1);
  EXPECT_EQ(late.referee.penalty(3), Penalty::none) << "ten seconds have passed";
}

TEST(RefereeOfThePitch, APersonMayPenaliseOnceAtATime) {
  Game game;
  game.play();
  game.referee.penalise(2, Penalty::pushing, game.now_ns);
  game.referee.penalise(2, Penalty::ball_holding, game.now_ns);
  game.referee.penalise(99, Penalty::pushing, game.now_ns);
  game.run(0.2);
  EXPECT_EQ(game.referee.penalty(2), Penalty::pushing);
  EXPECT_EQ(game.count(Kind::penalty), 1);
  EXPECT_EQ(game.moves.size(), 1u);
  game.robots[0] = {0, 5, false};
  game.run(0.2);
  EXPECT_EQ(game.referee.penalty(0), Penalty::left_field);
}

}  // namespace
}  // namespace sinew::plant::referee_test
