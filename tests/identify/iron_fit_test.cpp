// Vehicles whose iron the fit does not know, turned about in the field of the earth.
#include "identify/iron_fit.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "math/random.hpp"

namespace sinew::identify::iron_fit_test {
namespace {

using math::Mat3;
using math::Quat;
using math::Vec3;
using ::testing::HasSubstr;

constexpr double kField_t = 48e-6, kNoise_t = 0.3e-6;

struct Vehicle {
  Vec3 hard_t;
  Mat3 soft;  // what the fit is to find
};

Vehicle secret(math::Random& random) {
  const auto off = [&](double by) { return random.uniform(-by, by); };
  const double xy = off(0.1), xz = off(0.1), yz = off(0.1);
  return {{off(40e-6), off(40e-6), off(40e-6)}, {1 + off(0.2), xy, xz, xy, 1 + off(0.2), yz, xz, yz, 1 + off(0.2)}};
}

/// One axis after the other goes round, as by hand; a field that comes from the north and from above.
std::vector<Vec3> turned(const Vehicle& v, math::Random& random, std::size_t count, double noise_t, double tilt_rad) {
  const Vec3 field = normalized(Vec3{0, 0.45, -0.89}) * kField_t;
  const auto bent = math::inverse(v.soft);
  std::vector<Vec3> readings;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = static_cast<double>(i) / static_cast<double>(count);
    const Quat q = Quat::from_axis_angle({0, 0, 1}, 2 * math::kPi * 9 * t) *
                   Quat::from_axis_angle({1, 0, 0}, tilt_rad * math::sin(2 * math::kPi * 5 * t)) *
                   Quat::from_axis_angle({0, 1, 0}, tilt_rad * math::cos(2 * math::kPi * 2 * t));
    const Vec3 noise{random.normal(0, noise_t), random.normal(0, noise_t), random.normal(0, noise_t)};
    readings.push_back(*bent * q.conjugate().rotate(field) + v.hard_t + noise);
  }
  return readings;
}

std::array<double, kIronNumbers> truth_of(const Vehicle& v) {
  return {v.hard_t.x,   v.hard_t.y,   v.hard_t.z,   v.soft(0, 0), v.soft(1, 1),
          v.soft(2, 2), v.soft(0, 1), v.soft(0, 2), v.soft(1, 2)};
}

TEST(IronFit, FindsSecretIronAndItsIntervalsHold) {
  std::size_t held = 0, all = 0;
  double most_nt = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    math::Random random(seed, 3);
    const Vehicle v = secret(random);
    const IronFit fit = fit_iron(turned(v, random, 600, kNoise_t, math::kPi), {.field_t = kField_t});
    ASSERT_EQ(fit.problem, "") << seed;
    EXPECT_TRUE(fit.shown) << fit.worst_deg;
    EXPECT_LT(fit.rms_t, 1.3 * kNoise_t) << "the noise, and soft iron makes it larger";
    EXPECT_LT(fit.held_out_rms_t, 1.5 * kNoise_t);
    const auto truth = truth_of(v);
    for (std::size_t i = 0; i < kIronNumbers; ++i, ++all)
      held += std::abs(fit.estimates[i].value - truth[i]) <= fit.estimates[i].half_width;
    for (int i = 0; i < 3; ++i) {
      const double e = std::abs(fit.estimates[static_cast<std::size_t>(i)].value - truth[static_cast<std::size_t>(i)]);
      most_nt = std::max(most_nt, 1e9 * e);
    }
  }
  EXPECT_GE(held, all * 92 / 100);
  EXPECT_LE(held, all * 995 / 1000);
  RecordProperty("held_of_900", static_cast<int>(held));
  EXPECT_LT(most_nt, 300) << "hard iron of 40 000 nT";
}

TEST(IronFit, WhereTheFieldIsNotKnownSoftIronKeepsVolumes) {
  math::Random random(7, 3);
  const Vehicle v = secret(random);
  const IronFit fit = fit_iron(turned(v, random, 600, kNoise_t, math::kPi));
  ASSERT_EQ(fit.problem, "");
  const double ratio = fit.soft(0, 0) / v.soft(0, 0);
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(fit.soft(r, c), ratio * v.soft(r, c), 0.01) << r << c;
  EXPECT_NEAR(fit.field_t, ratio * kField_t, 0.3e-6);
  EXPECT_NEAR(fit.hard_t.x, v.hard_t.x, 0.3e-6);
}

TEST(IronFit, ReadingsBesideAnIronDoorCountLittle) {
  math::Random random(8, 3);
  const Vehicle v = secret(random);
  auto readings = turned(v, random, 600, kNoise_t, math::kPi);
  for (std::size_t i = 100; i < 130; ++i) readings[i] += {9e-6, -4e-6, 6e-6};
  const IronFit fit = fit_iron(readings, {.field_t = kField_t});
  ASSERT_EQ(fit.problem, "");
  const auto truth = truth_of(v);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(fit.estimates[i].value, truth[i], 0.5e-6) << i;
}

TEST(IronFit, AReadingInTheVeryMiddleHasNoDirectionAndDoesNoHarm) {
  // Symmetric about 0, so that the mean of all, which is where the fit begins, is the odd one exactly.
  math::Random random(11, 3);
  const Vehicle v{{}, Mat3::identity()};
  std::vector<Vec3> readings;
  for (const Vec3& r : turned(v, random, 300, 0, math::kPi)) readings.push_back(r), readings.push_back(-r);
  readings.push_back({});
  const IronFit fit = fit_iron(readings, {.field_t = kField_t});
  ASSERT_EQ(fit.problem, "");
  EXPECT_NEAR(fit.soft(0, 0), 1, 0.01);
  EXPECT_LT(norm(fit.hard_t), 0.2e-6);
}

TEST(IronFit, ADirectionThatWasNotTurnedToIsNamed) {
  math::Random random(9, 3);
  const Vehicle v{{5e-6, -8e-6, 12e-6}, Mat3::identity()};
  // It stays nearly level: the field comes from above all the time.
  const IronFit fit = fit_iron(turned(v, random, 600, 5 * kNoise_t, 0.8), {.field_t = kField_t});
  ASSERT_EQ(fit.problem, "");
  EXPECT_FALSE(fit.shown) << fit.worst_deg;
  EXPECT_GT(fit.worst.z, 0.5) << "no field has come from below";
}

TEST(IronFit, WhatCannotBeFittedIsSaid) {
  math::Random random(10, 3);
  const Vehicle v = secret(random);
  auto readings = turned(v, random, 600, kNoise_t, math::kPi);
  EXPECT_THAT(fit_iron(std::span(readings).first(29)).problem, HasSubstr("29 readings; at least 30"));
  std::vector<Vec3> flat = readings;
  for (Vec3& r : flat) r.z = 1e-5;
  EXPECT_THAT(fit_iron(flat).problem, HasSubstr("in a plane"));
  EXPECT_THAT(fit_iron(std::vector<Vec3>(100, Vec3{1e-5, 2e-5, 3e-5})).problem, HasSubstr("in a plane, or all in one"));
  readings[5].y = math::kNan;
  EXPECT_THAT(fit_iron(readings).problem, HasSubstr("not finite"));
}

}  // namespace
}  // namespace sinew::identify::iron_fit_test
