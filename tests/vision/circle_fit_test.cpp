#include "vision/circle_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "math/random.hpp"

namespace sinew::vision::circle_fit_test {
namespace {

std::vector<PointPx> arc(double x, double y, double r, double from_rad, double to_rad, int n, double noise = 0) {
  math::Random random(5);
  std::vector<PointPx> points;
  for (int i = 0; i < n; ++i) {
    const double a = from_rad + (to_rad - from_rad) * i / n, d = r + noise * random.normal();
    points.push_back({x + d * std::cos(a), y + d * std::sin(a)});
  }
  return points;
}

TEST(CircleFit, FindsAPerfectCircleExactly) {
  const Circle c = fit_circle(arc(320.5, -40, 77, 0, 6.28, 100));
  ASSERT_TRUE(c.valid);
  EXPECT_NEAR(c.x, 320.5, 1e-9);
  EXPECT_NEAR(c.y, -40, 1e-9);
  EXPECT_NEAR(c.radius, 77, 1e-9);
  EXPECT_NEAR(c.rms, 0, 1e-9);
}

TEST(CircleFit, FindsTheCircleOfAnArcOfSixtyDegrees) {
  const Circle c = fit_circle(arc(100, 50, 200, 0.2, 0.2 + 1.05, 200, 0.3));
  ASSERT_TRUE(c.valid);
  EXPECT_NEAR(c.x, 100, 6);
  EXPECT_NEAR(c.y, 50, 6);
  EXPECT_NEAR(c.radius, 200, 8);
  EXPECT_NEAR(c.rms, 0.3, 0.06);
}

TEST(CircleFit, RefusesLinesAndTooFewPoints) {
  EXPECT_FALSE(fit_circle({}).valid);
  EXPECT_FALSE(fit_circle(arc(0, 0, 5, 0, 2, 2)).valid);
  std::vector<PointPx> line;
  for (int i = 0; i < 20; ++i) line.push_back({double(i), 2.0 * i});
  EXPECT_FALSE(fit_circle(line).valid);
  EXPECT_FALSE(fit_circle(std::vector<PointPx>(10, {3, 3})).valid);
}

}  // namespace
}  // namespace sinew::vision::circle_fit_test
