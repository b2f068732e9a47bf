#include "soccer/world/pose_score.hpp"

#include <gtest/gtest.h>
#include <algorithm>
#include <cstring>
#include <vector>

#include "math/elementary.hpp"
#include "math/random.hpp"

namespace sinew::soccer::pose_score_test {
namespace {

using Kind = ScoredSight::Kind;

ScoredPoses poses_anywhere(std::size_t count) {
  ScoredPoses poses;
  math::Random random(5);
  while (poses.count < count) poses.add(random.uniform(-6, 6), random.uniform(-5, 5), random.uniform(-4, 4));
  return poses;
}

std::vector<ScoredSight> sights_anywhere() {
  std::vector<ScoredSight> sights;
  math::Random random(6);
  for (int i = 0; i < 21; ++i) {
    ScoredSight o;
    o.kind = static_cast<Kind>(i % 7);
    const math::SinCos t = math::sincos(random.uniform(-4, 4));
    o.ahead = static_cast<float>(t.cos), o.left = static_cast<float>(t.sin);
    o.x_m = static_cast<float>(random.uniform(-1, 5)), o.y_m = static_cast<float>(random.uniform(-3, 3));
    o.half_m = static_cast<float>(random.uniform(0.1, 1)), o.per_m2 = 8, o.per_angle2 = 20;
    sights.push_back(o);
  }
  return sights;
}

/// The distance of a piece of line from the nearest field line of its direction, by going through all of them.
double off_lines(const Field& field, double x, double y, bool by_x, double half) {
  double best = 1e9;
  for (const FieldLine& l : field.lines()) {
    if ((l.from.y_m == l.to.y_m) != by_x) continue;
    const double off = by_x ? y - l.from.y_m : x - l.from.x_m, at = by_x ? x : y;
    const double low = by_x ? std::min(l.from.x_m, l.to.x_m) : std::min(l.from.y_m, l.to.y_m);
    const double high = by_x ? std::max(l.from.x_m, l.to.x_m) : std::max(l.from.y_m, l.to.y_m);
    const double out = std::max({0.0, at + half - high, low - (at - half)});
    best = std::min(best, off * off + out * out);
  }
  return best;
}

TEST(PoseScore, FourAtATimeHaveTheBitsOfOneByOne) {
  const Field field;
  const PoseScore score(field);
  for (const std::size_t count : {1U, 3U, 8U, 499U, 512U}) {
    ScoredPoses a = poses_anywhere(count), b = a;
    score.score(sights_anywhere(), a);
    score.score_one_by_one(sights_anywhere(), b);
    EXPECT_EQ(std::memcmp(a.cost.data(), b.cost.data(), count * sizeof(float)), 0) << count;
    EXPECT_NE(a.cost[0], 0) << "it does score";
  }
}

TEST(PoseScore, ALineCostsItsDistanceFromTheNearestFieldLine) {
  const Field field;
  const PoseScore score(field);
  math::Random random(9);
  for (int i = 0; i < 300; ++i) {
    const bool by_x = i % 2 == 0;
    const double x = random.uniform(-5, 5), y = random.uniform(-3.5, 3.5), half = random.uniform(0.1, 0.6);
    // One that is longer than a field line beyond the middle is compared with the nearer of its ends only.
    if (math::fabs(x) < half || math::fabs(y) < half) continue;
    ScoredPoses poses;
    poses.add(0, 0, 0);
    const ScoredSight o{Kind::line,
                        static_cast<float>(x),
                        static_cast<float>(y),
                        by_x ? 1.0F : 0.0F,
                        by_x ? 0.F : 1.F,
                        static_cast<float>(half),
                        1,
                        1,
                        100};
    score.score({&o, 1}, poses);
    EXPECT_NEAR(double{poses.cost[0]}, off_lines(field, x, y, by_x, half), 1e-4) << x << ' ' << y << ' ' << by_x;
  }
}

TEST(PoseScore, WhatIsNotThereCostsItsMostAndNotMore) {
  const Field field;
  const PoseScore score(field);
  ScoredPoses poses;
  poses.add(0, 0, 0);
  poses.add(40, 40, 0);
  ScoredSight o;
  o.kind = Kind::circle, o.per_m2 = 100, o.most = 6;
  score.score({&o, 1}, poses);
  EXPECT_EQ(poses.cost[0], 0);
  EXPECT_EQ(poses.cost[1], 6);
}

}  // namespace
}  // namespace sinew::soccer::pose_score_test
