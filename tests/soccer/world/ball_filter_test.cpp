#include "soccer/world/ball_filter.hpp"

#include <gtest/gtest.h>
#include <algorithm>

#include "math/random.hpp"

namespace sinew::soccer::ball_filter_test {
namespace {

constexpr std::int64_t kPictureNs = 50'000'000;

/// A robot that stands and a ball, seen 20 times a second with errors as large as it says.
struct Game {
  BallFilter filter;
  RollingBall ball{1.5, 0.3, 0, 0};  // frame of the odometry
  FieldAt robot;
  math::Random random{11};
  msg::SoccerSight sight;
  double seen = 0.8;  // share of the pictures
  bool visible = true;

  Game() { filter.options().sight_scale = 1; }  // nothing of its errors lasts

  void step(int pictures = 1) {
    for (int i = 0; i < pictures; ++i) {
      const std::int64_t now = sight.stamp.ns + kPictureNs;
      ball = ball.after(1e-9 * kPictureNs, 0.35);
      sight = {};
      sight.stamp = {now};
      sight.x_m = robot.x_m, sight.y_m = robot.y_m, sight.heading_rad = robot.heading_rad;
      if (visible && random.uniform() < seen) {
        const FieldPoint at = robot.in(ball.x_m, ball.y_m);
        const double sigma = 0.02 + 0.03 * math::hypot(at.x_m, at.y_m);
        msg::SeenBall& b = sight.ball[sight.balls++];
        const auto v = static_cast<float>(sigma * sigma);
        b.at = {static_cast<float>(at.x_m + random.normal(0, sigma)),
                static_cast<float>(at.y_m + random.normal(0, sigma)), v, 0, v};
        b.confidence = 0.95F;
      }
      const auto places = filter.predict(sight);
      std::array<bool, BallFilter::kMost> shown{};
      std::fill_n(shown.begin(), places.size(), true);
      filter.see(sight, {shown.data(), places.size()});
    }
  }
  msg::BallModel model() const {
    msg::BallModel m;
    filter.fill(m);
    return m;
  }
  double off_m() const {
    const msg::BallModel m = model();
    const FieldPoint at = robot.out(m.x_m, m.y_m);
    return math::hypot(at.x_m - ball.x_m, at.y_m - ball.y_m);
  }
};

TEST(BallFilter, ARestingBallIsKnownBetterThanOneSightingAndHasNoSpeed) {
  Game g;
  g.step(60);
  EXPECT_LT(g.off_m(), 0.04);  // a sighting: 0.066 m for each axis
  EXPECT_GT(g.model().confidence, 0.9);
  EXPECT_LT(math::hypot(g.model().vx_mps, g.model().vy_mps), 0.05);
}

TEST(BallFilter, ABallThatIsKickedIsFollowedAndItsRestIsForetold) {
  Game g;
  g.step(40);
  g.ball.vx_mps = 1.2, g.ball.vy_mps = -0.5;
  g.step(20);  // 1 s
  EXPECT_LT(g.off_m(), 0.12);
  const msg::BallModel m = g.model();
  EXPECT_NEAR(m.vx_mps, g.ball.vx_mps, 0.25);
  EXPECT_NEAR(m.vy_mps, g.ball.vy_mps, 0.25);
  const RollingBall end = RollingBall{m.x_m, m.y_m, m.vx_mps, m.vy_mps}.after(10, 0.35), truth = g.ball.after(10, 0.35);
  EXPECT_LT(math::hypot(end.x_m - truth.x_m, end.y_m - truth.y_m), 0.6);
}

TEST(BallFilter, OutOfSightItRollsOnAndIsLessSure) {
  Game g;
  g.step(20);
  g.ball.vx_mps = 1;
  g.step(20);
  const msg::BallModel before = g.model();
  g.visible = false;
  for (int i = 0; i < 20; ++i) {  // not in any picture
    const std::int64_t now = g.sight.stamp.ns + kPictureNs;
    g.ball = g.ball.after(1e-9 * kPictureNs, 0.35);
    g.sight = {};
    g.sight.stamp = {now};
    g.filter.predict(g.sight);
    g.filter.see(g.sight, {});
  }
  EXPECT_LT(g.off_m(), 0.35);
  EXPECT_GT(g.model().covariance[0], before.covariance[0]);
  EXPECT_LT(g.model().confidence, before.confidence);
  EXPECT_EQ(g.model().gone, 0U) << "nobody looked";
  EXPECT_EQ(g.model().seen, before.seen);
}

TEST(BallFilter, ABallThatIsNotWhereItShouldBeIsGoneUntilItIsSeenAgain) {
  Game g;
  g.step(20);
  g.visible = false;
  g.step(20);
  EXPECT_EQ(g.model().gone, 1U);
  EXPECT_LT(g.model().confidence, 0.2);
  g.visible = true;
  g.ball = {-0.5, 1, 0, 0};
  g.step(20);
  EXPECT_EQ(g.model().gone, 0U);
  EXPECT_LT(g.off_m(), 0.1);
}

TEST(BallFilter, OneFalseSightingIsNoBall) {
  Game g;
  g.seen = 0;
  g.step(3);
  g.seen = 1;
  g.step(1);
  g.seen = 0;
  g.step(1);
  EXPECT_EQ(g.model().seen, msg::Time{0});
  EXPECT_EQ(g.model().confidence, 0);
}

TEST(BallFilter, ItStaysWhereItIsWhileTheRobotWalksAndTurns) {
  Game g;
  for (int i = 0; i < 100; ++i) {
    g.robot = g.robot.then({0.01, 0, 0.01});
    g.step();
  }
  EXPECT_LT(g.off_m(), 0.06);
  const msg::BallModel m = g.model();
  EXPECT_NEAR(g.robot.in(1.5, 0.3).x_m, m.x_m, 0.06);
}

TEST(RollingBall, SlowsDownAndStops) {
  const RollingBall b{0, 0, 0.7, 0};
  EXPECT_NEAR(b.after(1, 0.35).vx_mps, 0.35, 1e-12);
  EXPECT_NEAR(b.after(5, 0.35).x_m, 0.7, 1e-12);  // v^2 / (2 a)
  EXPECT_EQ(b.after(5, 0.35).vx_mps, 0);
  EXPECT_EQ(b.after(-1, 0.35).x_m, 0);
}

}  // namespace
}  // namespace sinew::soccer::ball_filter_test
