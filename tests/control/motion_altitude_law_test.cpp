// The law in a small world of its own: a mass with drag over ground of given heights, and a detector without errors.
#include "control/motion_altitude_law.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace sinew::control::motion_altitude_law_test {
namespace {

using msg::AltitudePhase;

constexpr double kG = 9.81, kDt_s = 0.005;

struct Flight {
  MotionAltitudeLaw law;
  std::function<double(double)> ground = [](double) { return 0.0; };
  double wind_mps = 0, zero_mps2 = 0.05, mass_kg = 1.23, motion_factor = 1;
  bool sees = true, by_range = false;
  double x = 0, z = 0.12, vx = 0, vz = 0, pitch = 0, thrust_n = 0;
  int steps = 0;
  msg::FailsafeAction action = msg::FailsafeAction::none;

  double height() const { return z - ground(x); }
  double right() const { return vx / law.params.wanted_motion_radps; }

  void step() {
    const math::Quat q = math::Quat::from_axis_angle({0, 1, 0}, pitch);
    const double air = vx - wind_mps, drag = -air * (0.28 + 0.06 * std::fabs(air)) * std::cos(pitch);
    const math::Vec3 force = q.rotate({drag / mass_kg, 0, thrust_n / mass_kg});
    const bool stands = z <= 0.12 && thrust_n <= mass_kg * kG;
    if (!stands) {
      vx += force.x * kDt_s;
      vz += (force.z - kG) * kDt_s;
    }
    x += vx * kDt_s, z += vz * kDt_s;

    msg::GroundMotion motion;
    motion.forward_radps = motion_factor * vx / (height() - 0.04);
    motion.seen = 1;
    MotionAltitudeLaw::Input in;
    in.nav.q_world_base = q.to<msg::Quat>();
    in.nav.attitude_valid = 1;
    in.force_mps2 = stands ? math::Vec3{zero_mps2, 0, kG} : q.conjugate().rotate(force) + math::Vec3{zero_mps2, 0, 0};
    in.action = action;
    if (sees && steps % 7 == 0) in.motion = &motion;
    in.by_range = by_range;
    if (by_range && steps % 2 == 0) in.range_m = (height() - 0.04) / std::cos(pitch);
    ++steps;
    law.step(in, {steps * 5'000'000}, kDt_s);
    const double blend = kDt_s / 0.1;  // of the loops below
    const math::Quat wanted(law.setpoint().q_world_base);
    pitch += blend * (2 * std::atan2(wanted.y, wanted.w) - pitch);
    thrust_n += kDt_s / 0.03 * ((law.setpoint().armed ? law.setpoint().thrust_n : 0) - thrust_n);
  }
  void fly(double seconds) {
    for (int i = 0; i < seconds / kDt_s; ++i) step();
  }
};

TEST(MotionAltitude, TakesOffAndHoldsTheHeightThatSpeedAndMotionGive) {
  Flight f;
  f.fly(25);
  EXPECT_EQ(f.law.state().phase, AltitudePhase::follow);
  EXPECT_NEAR(f.vx, 1.5, 0.08);  // by the accelerometer, whose zero is off
  EXPECT_NEAR(f.height(), 2, 0.1);
}

TEST(MotionAltitude, FollowsRampsAndStepsOfAFifthOfTheHeight) {
  Flight f;
  f.ground = [](double x) {
    if (x < 30) return 0.0;
    if (x < 45) return (x - 30) / 4;  // a ramp of 1 : 4
    return 3.75 + 0.4 * (static_cast<int>(x / 6) % 2);
  };
  f.fly(20);
  double most = 0;
  for (int i = 0; i < 40 / kDt_s; ++i) {
    f.step();
    most = std::max(most, std::fabs(f.height() / f.right() - 1));
  }
  EXPECT_GT(f.x, 60);
  EXPECT_LT(most, 0.3);
}

TEST(MotionAltitude, AHeadWindMakesItSink) {
  Flight calm, wind;
  wind.wind_mps = -0.6;
  calm.fly(40), wind.fly(40);
  EXPECT_NEAR(wind.vx, 0.9, 0.08);
  EXPECT_NEAR(wind.height(), wind.right(), 0.1);
  EXPECT_LT(wind.height(), 0.7 * calm.height());
}

TEST(MotionAltitude, ADetectorThatReadsHalfFliesAtHalfTheHeight) {
  Flight f;
  f.motion_factor = 0.5;
  f.fly(40);
  EXPECT_NEAR(f.height(), 1, 0.1);
}

TEST(MotionAltitude, TheRangeFindersHeightTakesThePlaceOfTheMotions) {
  Flight f;
  f.by_range = true;
  f.motion_factor = 0.5;
  f.fly(40);
  EXPECT_NEAR(f.height(), 2, 0.1);
}

TEST(MotionAltitude, WithoutMotionItNeitherClimbsNorSinksForAWhile) {
  Flight f;
  f.fly(25);
  f.sees = false;
  const double before = f.height();
  f.fly(1.5);
  EXPECT_NEAR(f.height(), before, 0.3);
  EXPECT_EQ(f.law.state().motion_fresh, 0u);
}

TEST(MotionAltitude, ComesDownAndDisarmsWhenAFailsafeAsksForIt) {
  Flight f;
  f.fly(25);
  f.action = msg::FailsafeAction::land;
  f.fly(2);
  EXPECT_EQ(f.law.state().phase, AltitudePhase::land);
  EXPECT_LT(f.vz, -0.05);
  f.fly(9);
  EXPECT_EQ(f.law.state().phase, AltitudePhase::done);
  EXPECT_EQ(f.law.setpoint().armed, 0u);
}

TEST(MotionAltitude, TheAirspeedIsTheDragsInverse) {
  const MotionAltitudeParams p;
  for (const double v : {-3.0, -0.5, 0.0, 0.2, 1.5, 6.0}) {
    const double force = -(p.drag_n_per_mps * v + p.drag_n_per_m2ps2 * v * std::fabs(v)) / p.mass_kg;
    EXPECT_NEAR(MotionAltitudeLaw::airspeed_of(force, p), v, 1e-9);
  }
}

}  // namespace
}  // namespace sinew::control::motion_altitude_law_test
