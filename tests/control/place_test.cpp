// The stated covariance of a place that a mate has seen is that of many drawn poses and sightings.
#include "control/place.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "math/random.hpp"

namespace sinew::control::place_test {
namespace {

using math::Mat3;
using math::Quat;
using math::Vec3;

/// A pose with position errors of `p` m, rotation errors of `t` rad, and `pt` of them in common.
UncertainPose pose(const Vec3& p_m, const Vec3& rotation, const Vec3& p, const Vec3& t, double common) {
  UncertainPose made;
  made.p_m = p_m;
  made.q = Quat::exp(rotation);
  for (int i = 0; i < 3; ++i) {
    made.covariance(i, i) = p[i] * p[i];
    made.covariance(3 + i, 3 + i) = t[i] * t[i];
    made.covariance(i, 3 + i) = made.covariance(3 + i, i) = common * p[i] * t[i];
  }
  return made;
}

/// The true pose, drawn from what is known of it.
UncertainPose drawn(const UncertainPose& known, math::Random& random) {
  UncertainPose truth = known;
  Vec3 t;
  for (int i = 0; i < 3; ++i) {
    const double sp = std::sqrt(known.covariance(i, i)), st = std::sqrt(known.covariance(3 + i, 3 + i));
    const double common = sp > 0 && st > 0 ? known.covariance(i, 3 + i) / (sp * st) : 0;
    const double a = random.normal(), b = random.normal();
    truth.p_m[i] += sp * a;
    t[i] = st * (common * a + std::sqrt(1 - common * common) * b);
  }
  truth.q = Quat::exp(t) * known.q;
  return truth;
}

Vec3 drawn(const Place& known, math::Random& random) {
  Vec3 p = known.p_m;  // its covariance is diagonal here
  for (int i = 0; i < 3; ++i) p[i] += std::sqrt(known.covariance_m2(i, i)) * random.normal();
  return p;
}

const UncertainPose kMate = pose({2, -1, 0.5}, {0.1, -0.2, 1.9}, {0.05, 0.1, 0.02}, {0.01, 0.02, 0.05}, 0.6);
const UncertainPose kOwn = pose({-1, 0.5, 1.2}, {-0.2, 0.1, -0.7}, {0.08, 0.03, 0.05}, {0.02, 0.01, 0.03}, -0.4);
const Place kSeen{{3, 1, -0.4}, Mat3{0.04, 0, 0, 0, 0.01, 0, 0, 0, 0.0025}};

TEST(PlaceOfAMate, StatedCovarianceIsThatOfManyTruths) {
  const Place stated = from_team(kOwn, to_team(kMate, kSeen));
  math::Random random(11);
  constexpr int kDraws = 40000;
  Mat3 sum;
  Vec3 mean;
  for (int i = 0; i < kDraws; ++i) {
    const UncertainPose mate = drawn(kMate, random), own = drawn(kOwn, random);
    const Vec3 in_team = mate.p_m + mate.q.rotate(drawn(kSeen, random));
    const Vec3 error = own.q.conjugate().rotate(in_team - own.p_m) - stated.p_m;
    sum += math::outer(error, error) * (1.0 / kDraws);
    mean += error * (1.0 / kDraws);
  }
  EXPECT_LT(math::norm(mean), 0.02);
  const double scale = stated.covariance_m2.trace() / 3;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum(r, c), stated.covariance_m2(r, c), 0.06 * scale) << r << ' ' << c;
}

TEST(PlaceOfAMate, ThereAndBackIsTheSamePlaceAndLessSure) {
  const Place back = from_team(kMate, to_team(kMate, kSeen));
  EXPECT_LT(math::norm(back.p_m - kSeen.p_m), 1e-12);
  EXPECT_GT(back.covariance_m2.trace(), kSeen.covariance_m2.trace());
  UncertainPose certain = kMate;
  certain.covariance = {};
  const Place exact = from_team(certain, to_team(certain, kSeen));
  for (int i = 0; i < 9; ++i)
    EXPECT_NEAR(exact.covariance_m2.a[std::size_t(i)], kSeen.covariance_m2.a[std::size_t(i)], 1e-15);
}

TEST(PlaceOfAMate, AHeadingErrorCountsWithTheDistance) {
  const UncertainPose turned = pose({}, {}, {}, {0, 0, 0.1}, 0);
  EXPECT_NEAR(to_team(turned, {{5, 0, 0}, {}}).covariance_m2(1, 1), 0.25, 1e-12);
  EXPECT_NEAR(to_team(turned, {{5, 0, 0}, {}}).covariance_m2(0, 0), 0, 1e-12);
}

TEST(PlaceOfAMate, PosesComeByMessage) {
  msg::TeamPose message;
  message.p_team_m = {1, 2, 3};
  message.q_team_base = {0, 0, 0, 1};
  message.covariance[7] = 0.5;  // row 1, column 1
  const UncertainPose got = to_pose(message);
  EXPECT_EQ(got.p_m, Vec3(1, 2, 3));
  EXPECT_EQ(got.q.rotate({1, 0, 0}), Vec3(-1, 0, 0));
  EXPECT_EQ(got.covariance(1, 1), 0.5);
}

}  // namespace
}  // namespace sinew::control::place_test
