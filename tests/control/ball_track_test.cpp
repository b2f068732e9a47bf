#include "control/ball_track.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "math/random.hpp"

namespace sinew::control::ball_track_test {
namespace {

using math::Vec3;
using msg::Time;

constexpr Time at(double s) { return {static_cast<std::int64_t>(s * 1e9)}; }
Vec3 towards(double azimuth, double elevation) {
  return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation)};
}

TEST(BallTrack, LearnsTheSpeedAndPredictsWithIt) {
  BallTrack track;
  for (int i = 0; i < 30; ++i) EXPECT_TRUE(track.add(at(1 + i / 30.0), towards(0.5 * i / 30.0, -0.2 * i / 30.0)));
  const BallTrack::Aim now = track.at(track.stamp());
  EXPECT_NEAR(now.azimuth_radps, 0.5, 0.01);
  EXPECT_NEAR(now.elevation_radps, -0.2, 0.01);
  const BallTrack::Aim soon = track.at(track.stamp() + std::chrono::milliseconds(100));
  EXPECT_NEAR(soon.azimuth_rad - now.azimuth_rad, 0.05, 0.002);
}

TEST(BallTrack, NoiseIsSmoothed) {
  BallTrack track;
  math::Random random(3);
  double raw = 0, smooth = 0;
  for (int i = 0; i < 600; ++i) {
    const double off = 0.004 * random.normal();
    track.add(at(i / 30.0), towards(off, 0.1));
    if (i < 30) continue;
    raw += off * off;
    smooth += std::pow(track.at(track.stamp()).azimuth_rad, 2);
  }
  EXPECT_LT(smooth, 0.8 * raw);
}

TEST(BallTrack, OneWrongSightingIsRefusedAndThreeAreAnotherBall) {
  BallTrack track;
  for (int i = 0; i < 30; ++i) track.add(at(i / 30.0), towards(0, 0));
  EXPECT_FALSE(track.add(at(30 / 30.0), towards(0.5, 0)));
  EXPECT_TRUE(track.add(at(31 / 30.0), towards(0, 0)));
  EXPECT_FALSE(track.add(at(32 / 30.0), towards(0.5, 0)));
  EXPECT_FALSE(track.add(at(33 / 30.0), towards(0.5, 0)));
  EXPECT_TRUE(track.add(at(34 / 30.0), towards(0.5, 0)));
  EXPECT_NEAR(track.at(track.stamp()).azimuth_rad, 0.5, 1e-9);
  EXPECT_EQ(track.at(track.stamp()).azimuth_radps, 0);
}

TEST(BallTrack, ABallThatPassesBelowIsTheSameBallOnTheOtherSide) {
  for (const double beside : {0.0, 0.02, -0.2}) {
    BallTrack track;
    track.params.below = 1;
    math::Random random(5);
    int refused = 0;
    for (int i = 0; i < 120; ++i) {
      Vec3 d{1 - i / 60.0, beside, -1.5};
      d += {0.004 * random.normal(), 0.004 * random.normal(), 0};
      refused += track.add(at(1 + i / 30.0), math::normalized(d)) ? 0 : 1;
      const BallTrack::Aim aim = track.at(track.stamp());
      const Vec3 seen = math::normalized(Vec3{1 - i / 60.0, beside, -1.5});
      if (i > 3) {
        EXPECT_GT(dot(seen, towards(aim.azimuth_rad, aim.elevation_rad)), std::cos(0.03)) << beside << " " << i;
      }
    }
    EXPECT_LE(refused, 2) << beside;
    EXPECT_GT(track.at(track.stamp()).elevation_rad, -math::kPi / 2);
  }
}

TEST(BallTrack, TheSameOrAnOlderSightingCountsOnce) {
  BallTrack track;
  EXPECT_TRUE(track.add(at(1), towards(0, 0)));
  EXPECT_FALSE(track.add(at(1), towards(0.01, 0)));
  EXPECT_FALSE(track.add(at(0.9), towards(0.01, 0)));
  EXPECT_EQ(track.used(), 1u);
}

TEST(BallTrack, UnseenItComesToRestNearWhereItWasLost) {
  BallTrack track;
  for (int i = 0; i < 30; ++i) track.add(at(i / 30.0), towards(0.6 * i / 30.0, 0));
  const double left_at = track.at(track.stamp()).azimuth_rad;
  const BallTrack::Aim late = track.at(track.stamp() + std::chrono::seconds(5));
  EXPECT_NEAR(late.azimuth_radps, 0, 1e-3);
  const double way = 0.6 * (0.15 + 0.4);  // at the last speed, which fades
  EXPECT_GT(track.at(track.stamp() + std::chrono::milliseconds(600)).azimuth_rad, left_at + 0.6 * way);
  EXPECT_NEAR(late.azimuth_rad, left_at + 0.3 * way, 0.02) << "else it would have come out on the other side";
}

TEST(BallTrack, WhatComesBackElsewhereMakesNoSpeedOfTheWayBetween) {
  BallTrack track;
  for (int i = 0; i < 30; ++i) track.add(at(i / 30.0), towards(0, 0));
  ASSERT_TRUE(track.add(at(1.4), towards(0.3, -0.4)));
  const BallTrack::Aim a = track.at(track.stamp());
  EXPECT_NEAR(a.azimuth_rad, 0.3, 1e-9);
  EXPECT_LT(std::fabs(a.elevation_radps), 0.1);
}

TEST(BallTrack, GoesThroughTheBackWithoutAJump) {
  BallTrack track;
  for (int i = 0; i < 60; ++i) EXPECT_TRUE(track.add(at(i / 30.0), towards(3.0 + 0.3 * i / 30.0, 0))) << i;
  EXPECT_NEAR(track.at(track.stamp()).azimuth_radps, 0.3, 0.01);
}

}  // namespace
}  // namespace sinew::control::ball_track_test
