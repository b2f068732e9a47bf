// The way of a wheeled robot round a wall.
#include "robots/gripper/wall_way.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "math/elementary.hpp"

namespace sinew::gripper::wall_way_test {
namespace {

using soccer::FieldPoint;

constexpr Wall kWall{0.4, -1.2, 0.8};
constexpr double kMargin_m = 0.35;

/// Walks there in steps of 1 cm; so many steps, and how near it came to the wall.
struct Walked {
  int steps = 0;
  double nearest_m = math::kInf;
};
Walked walk(FieldPoint at, const FieldPoint& to) {
  Walked walked;
  WallEnd end = WallEnd::none;
  for (; walked.steps < 3000 && math::hypot(at.x_m - to.x_m, at.y_m - to.y_m) > 0.02; ++walked.steps) {
    const FieldPoint next = way_round(at, to, kWall, kMargin_m, end);
    const double dx = next.x_m - at.x_m, dy = next.y_m - at.y_m, far = math::hypot(dx, dy);
    if (far > 0) at = {at.x_m + 0.01 * dx / far, at.y_m + 0.01 * dy / far};
    const double beside = at.y_m < kWall.from_y_m ? kWall.from_y_m - at.y_m
                          : at.y_m > kWall.to_y_m ? at.y_m - kWall.to_y_m
                                                  : 0;
    walked.nearest_m = std::min(walked.nearest_m, math::hypot(at.x_m - kWall.x_m, beside));
  }
  return walked;
}

TEST(WallWay, IsStraightWhereNothingStands) {
  WallEnd end = WallEnd::none;
  const FieldPoint to{2, 0};
  const FieldPoint next = way_round({-2, 0}, to, {0.4, 1, 1}, kMargin_m, end);
  EXPECT_EQ(next.x_m, to.x_m);
  EXPECT_EQ(end, WallEnd::none);
  EXPECT_FALSE(is_blocked({-2, -2}, {2, -2}, kWall, kMargin_m));
  EXPECT_TRUE(is_blocked({-2, 0}, {2, 0}, kWall, kMargin_m));
  EXPECT_FALSE(is_blocked({-2, 0}, {-0.5, 0}, kWall, kMargin_m)) << "it ends before the wall";
}

TEST(WallWay, ComesFromEitherSideToTheOtherAndNeverNearerThanTheMargin) {
  for (const double from_y : {-2.0, -0.7, 0.0, 0.7, 1.8})
    for (const double to_y : {-1.5, -0.6, 0.0, 0.6, 1.5})
      for (const double side : {1.0, -1.0}) {
        const Walked walked = walk({0.4 - side * 2.6, from_y}, {0.4 + side * 1.2, to_y});
        EXPECT_LT(walked.steps, 700) << from_y << " to " << to_y << " from side " << side;
        EXPECT_GT(walked.nearest_m, kMargin_m - 0.02) << from_y << " to " << to_y << " from side " << side;
      }
}

TEST(WallWay, GoesOnPastTheEndThatItChose) {
  WallEnd end = WallEnd::none;
  way_round({-2, -0.19}, {2, -0.2}, kWall, kMargin_m, end);
  const WallEnd chosen = end;
  ASSERT_NE(chosen, WallEnd::none);
  way_round({-1.9, -0.21}, {2, -0.2}, kWall, kMargin_m, end);
  EXPECT_EQ(end, chosen) << "a place that sways does not turn it round";
}

}  // namespace
}  // namespace sinew::gripper::wall_way_test
