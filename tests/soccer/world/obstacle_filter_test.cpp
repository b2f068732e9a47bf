#include "soccer/world/obstacle_filter.hpp"

#include <gtest/gtest.h>

#include "math/random.hpp"

namespace sinew::soccer::obstacle_filter_test {
namespace {

struct Pitch {
  ObstacleFilter filter;
  math::Random random{21};
  std::int64_t now = 0;
  FieldAt robot;

  /// A picture that shows robots at these places of the odometry's frame.
  void see(std::initializer_list<FieldPoint> places, msg::JerseyColour colour = msg::JerseyColour::unknown) {
    msg::SoccerSight sight;
    sight.stamp = {now += 100'000'000};
    sight.x_m = robot.x_m, sight.y_m = robot.y_m, sight.heading_rad = robot.heading_rad;
    for (const FieldPoint& p : places) {
      const FieldPoint at = robot.in(p.x_m, p.y_m);
      sight.robot[sight.robots++] = {{static_cast<float>(at.x_m + random.normal(0, 0.08)),
                                      static_cast<float>(at.y_m + random.normal(0, 0.08)), 0.02F, 0, 0.02F},
                                     0.7F,
                                     colour};
    }
    filter.see(sight);
  }
  msg::ObstacleModel model() {
    msg::ObstacleModel m;
    filter.fill(m);
    return m;
  }
};

TEST(ObstacleFilter, WhatWasSeenSeveralTimesAtOnePlaceIsAnObstacle) {
  Pitch p;
  for (int i = 0; i < 12; ++i) p.see({{1, 0.5}, {2, -1}}, msg::JerseyColour::red);
  const msg::ObstacleModel m = p.model();
  ASSERT_EQ(m.obstacles, 2U);
  EXPECT_LT(math::hypot(m.obstacle[0].x_m - 1, m.obstacle[0].y_m - 0.5), 0.1) << "the nearest first";
  EXPECT_LT(math::hypot(m.obstacle[1].x_m - 2, m.obstacle[1].y_m + 1), 0.1);
  EXPECT_EQ(m.obstacle[0].colour, msg::JerseyColour::red);
  EXPECT_LT(m.obstacle[0].sigma_m, 0.1);
}

TEST(ObstacleFilter, ScatteredFalseSightingsAreNone) {
  Pitch p;
  for (int i = 0; i < 40; ++i) p.see({{p.random.uniform(0.5, 5), p.random.uniform(-3, 3)}});
  EXPECT_LE(p.model().obstacles, 1U);
}

TEST(ObstacleFilter, ARobotThatWentAwayIsForgotten) {
  Pitch p;
  for (int i = 0; i < 12; ++i) p.see({{1, 0.5}});
  for (int i = 0; i < 60; ++i) p.see({});
  EXPECT_EQ(p.model().obstacles, 0U);
}

TEST(ObstacleFilter, AWalkingRobotHasASpeedAndStaysOne) {
  Pitch p;
  for (int i = 0; i < 50; ++i) p.see({{1 + 0.02 * i, 0.5}});  // 0.2 m/s
  const msg::ObstacleModel m = p.model();
  ASSERT_EQ(m.obstacles, 1U);
  EXPECT_NEAR(m.obstacle[0].vx_mps, 0.2, 0.12);
  EXPECT_LT(math::hypot(m.obstacle[0].x_m - 1.98, m.obstacle[0].y_m - 0.5), 0.15);
}

TEST(ObstacleFilter, TheNearestStayWhenThereAreTooMany) {
  Pitch p;
  for (int i = 0; i < 12; ++i) {
    p.see({{1, 0}, {2, 0}, {3, 0}, {4, 0}, {5, 0}, {6, 0}, {7, 0}});
    p.see({{1, 4}, {2, 4}, {3, 4}, {4, 4}, {5, 4}, {6, 4}, {7, 4}});
  }
  const msg::ObstacleModel m = p.model();
  ASSERT_EQ(m.obstacles, m.obstacle.size());
  EXPECT_NEAR(m.obstacle[0].x_m, 1, 0.15);
  EXPECT_EQ(m.dropped, 2U);
  for (std::size_t i = 1; i < m.obstacles; ++i)
    EXPECT_LE(math::hypot(m.obstacle[i - 1].x_m, m.obstacle[i - 1].y_m),
              math::hypot(m.obstacle[i].x_m, m.obstacle[i].y_m));
}

}  // namespace
}  // namespace sinew::soccer::obstacle_filter_test
