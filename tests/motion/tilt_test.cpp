// The attitude of a torso from what a gyro and an accelerometer measure of a motion that is known.
#include "motion/tilt.hpp"

#include <gtest/gtest.h>

namespace sinew::motion::tilt_test {
namespace {

using math::Quat;
using math::Vec3;

constexpr double kStep_s = 0.01, kGravity_mps2 = 9.81;

TEST(Tilt, IsDrawnToTheAccelerometersDown) {
  Tilt tilt;
  tilt.start({0, 0, 9.81});
  const Quat leaning = Quat::from_axis_angle({0, 1, 0}, 0.1);
  const Vec3 accel = leaning.conjugate().rotate({0, 0, 9.81});
  for (int i = 0; i < 1500; ++i) tilt.step({}, accel, false, kStep_s);
  EXPECT_LT(math::angle_between(tilt.q_world_torso(), leaning), 0.01);
}

TEST(Tilt, TheShakingOfStepsLeavesItUpright) {
  Tilt tilt;
  tilt.start({0, 0, 9.81});
  double worst = 0;
  for (int i = 0; i < 3000; ++i) {
    const double phase = 2 * math::kPi * i * kStep_s / 0.6;
    tilt.step({}, {2 * math::sin(2 * phase), 3 * math::sin(phase), 9.81 + 5 * math::sin(2 * phase + 0.7)}, false,
              kStep_s);
    if (i > 500) worst = std::max(worst, math::angle_between(tilt.q_world_torso(), {}));
  }
  EXPECT_LT(worst, 0.06);
}

TEST(Tilt, LearnsTheBiasOfATorsoAtRestAlsoAboutTheVertical) {
  Tilt tilt;
  tilt.start({0, 0, 9.81});
  const Vec3 bias{0.01, -0.008, 0.012};
  for (int i = 0; i < 600; ++i) tilt.step(bias, {0, 0, 9.81}, true, kStep_s);
  EXPECT_LT(norm(tilt.bias_radps() - bias), 1e-3);
}

TEST(Tilt, TakesTheTurnOfABodyThatSettlesOnItsFeetForNoBiasAboutTheVertical) {
  Tilt tilt;
  tilt.start({0, 0, 9.81});
  for (double s = 0; s < 2.4; s += kStep_s) tilt.step({0, 0, s < 0.4 ? 0.032 : 0.012}, {0, 0, 9.81}, true, kStep_s);
  EXPECT_NEAR(tilt.bias_radps().z, 0.012, 3e-4);
}

/// A torso that leans forward and sways sideways once in two steps; it nods in the same rhythm, since of a walk to the
/// side every other step is a wide one: forward with the sway to the side that it walks to.
struct WalkToTheSide {
  double side = 1;  // 1: to the left
  double lean_rad = 0.05, roll_rad = 0.05, nod_rad = 0.03, sway_mps2 = 2, two_steps_s = 0.494;

  Quat attitude(double t_s) const {
    const double phase = 2 * math::kPi * t_s / two_steps_s;
    return Quat::from_yaw_pitch_roll(
        {.yaw = 0, .pitch = lean_rad + nod_rad * math::cos(phase), .roll = roll_rad * math::sin(phase)});
  }
  Vec3 gyro_radps(double t_s) const { return (attitude(t_s - kStep_s).conjugate() * attitude(t_s)).log() / kStep_s; }
  Vec3 accel_mps2(double t_s) const {
    const double sway = side * sway_mps2 * math::cos(2 * math::kPi * t_s / two_steps_s);
    return attitude(t_s).conjugate().rotate({0, sway, kGravity_mps2});
  }
};

TEST(Tilt, AMinuteOfWalkingToTheSideDoesNotTurnTheHeading) {
  for (const double side : {1.0, -1.0}) {
    const WalkToTheSide walk{.side = side};
    Tilt tilt;
    tilt.start(walk.attitude(0).conjugate().rotate({0, 0, kGravity_mps2}));
    double worst_rad = 0;
    for (int i = 1; i <= 6000; ++i) {
      const double t_s = i * kStep_s;
      tilt.step(walk.gyro_radps(t_s), walk.accel_mps2(t_s), false, kStep_s);
      worst_rad = std::max(worst_rad, math::fabs(tilt.q_world_torso().yaw()));
    }
    EXPECT_LT(worst_rad, 0.03) << "to the " << (side > 0 ? "left" : "right");
    EXPECT_LT(math::fabs(tilt.bias_radps().z), 1e-3);
    EXPECT_LT(norm(tilt.up() - walk.attitude(60).conjugate().rotate({0, 0, 1})), 0.03) << "and the tilt is known";
  }
}

}  // namespace
}  // namespace sinew::motion::tilt_test
