// The servo: its torque-speed line, its delays none, the play of its gear.
#include "sim_hil/pitch/servo.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "math/elementary.hpp"

namespace sinew::plant::servo_test {
namespace {

constexpr double kStep_s = 0.002;

/// A link on a servo, integrated as the pitch does: damping implicitly.
struct Joint {
  GearedServo servo;
  double load_kgm2 = 0.01, load_nm = 0;
  double limit = 1;
  double q = 0, v = 0, a = 0;

  void step(const JointDrive& drive) {
    const ServoTorque t = servo.step(drive, limit, q, v, a, kStep_s);
    const double inertia = load_kgm2 + servo.params().armature_kgm2;
    a = (t.effort_nm + load_nm - t.damping_nms * v) / (inertia + kStep_s * t.damping_nms);
    v += a * kStep_s;
    q += v * kStep_s;
  }
  void run(const JointDrive& drive, double seconds) {
    for (int i = 0; i < static_cast<int>(seconds / kStep_s + 0.5); ++i) step(drive);
  }
};

JointDrive towards(double rad) { return {DriveMode::position, rad}; }
constexpr double kDegree = math::kPi / 180;

TEST(ServoOfAJoint, RunsUpToItsNoLoadSpeedAndHoldsItsStallTorque) {
  for (const double no_load : {4.8, 5.8}) {
    Joint free{GearedServo({.no_load_radps = no_load})};
    free.run(towards(100), 1);
    EXPECT_NEAR(free.v, no_load, 0.01 * no_load);
    EXPECT_NEAR(free.servo.motor_nm(), 0, 0.01);
  }
  // Against a torque it turns as fast as the line between the two says.
  for (const double share : {0.25, 0.5, 0.75}) {
    Joint loaded{GearedServo({})};
    loaded.load_nm = -share * 4.1;
    loaded.run(towards(100), 1);
    EXPECT_NEAR(loaded.v, (1 - share) * 4.8, 0.02) << share;
  }
  Joint overloaded{GearedServo({})};
  overloaded.load_nm = -1.05 * 4.1;
  overloaded.run(towards(100), 0.5);
  EXPECT_LT(overloaded.q, 0) << "more than its stall torque pushes it back";
}

TEST(ServoOfAJoint, GivesWayByItsGain) {
  for (const double gain : {4.6, 12.0}) {
    Joint joint{GearedServo({.gain_per_rad = gain})};
    joint.load_nm = -1;
    joint.run(towards(0.5), 3);
    EXPECT_NEAR(joint.q, 0.5 - 1 / (4.1 * gain), 1e-3);
    EXPECT_NEAR(joint.servo.motor_nm(), 1, 1e-3);
  }
}

TEST(ServoOfAJoint, KeepsItsTorqueLimitAndGivesNoneWhenItIsOff) {
  Joint weak{GearedServo({})};
  weak.limit = 0.3;
  weak.load_nm = -0.35 * 4.1;
  weak.run(towards(10), 1);
  EXPECT_LT(weak.q, 0);
  Joint off{GearedServo({.friction_nm = 0.08})};
  off.load_nm = -0.5;
  off.run({}, 0.3);
  EXPECT_LT(off.v, -4.8) << "no bridge brakes it";
  EXPECT_EQ(off.servo.motor_nm(), 0);
  // Its friction stops it.
  off.load_nm = 0;
  off.run({}, 3);
  EXPECT_NEAR(off.v, 0, 1e-3);
}

TEST(ServoOfAJoint, FollowsSpeedsTorquesAndImpedances) {
  Joint joint{GearedServo({})};
  joint.run({DriveMode::velocity, 0, 2}, 1);
  EXPECT_NEAR(joint.v, 2, 0.02);
  Joint pushed{GearedServo({})};
  pushed.run({DriveMode::effort, 0, 0, 0.02}, 0.2);
  EXPECT_NEAR(pushed.v, 0.02 / 0.0145 * 0.2, 0.15 * pushed.v) << "back-EMF is made up for";
  Joint spring{GearedServo({})};
  spring.load_nm = 0.4;
  spring.run({DriveMode::impedance, 0.1, 0, 0, 10, 1}, 3);
  EXPECT_NEAR(spring.q, 0.1 + 0.4 / 10, 1e-3);
}

/// Pushes a limp joint by hand to both sides, with a small force: how far it moves. Its rotor is held by friction.
double wiggled_rad(double play_rad) {
  Joint joint{GearedServo({.play_rad = play_rad, .friction_nm = 0.6})};
  double least = 0, most = 0;
  for (int i = 0; i < 2000; ++i) {
    joint.load_nm = 0.05 * math::sin(2 * math::kPi * i / 500);
    joint.step({});
    least = std::min(least, joint.q), most = std::max(most, joint.q);
  }
  return most - least;
}

TEST(ServoOfAJoint, HasPlayOfTheStatedWidth) {
  const double tight = wiggled_rad(0);
  for (const double degrees : {0.25, 0.5, 1.0})
    EXPECT_NEAR((wiggled_rad(degrees * kDegree) - tight) / kDegree, 2 * degrees, 0.1 * degrees) << degrees;
}

TEST(ServoOfAJoint, CrossesItsPlayWhenTheLoadChangesItsSide) {
  // A load that pulls to either side: the rotor lies on one flank or the other.
  const double play = 0.25 * kDegree;
  for (const bool at_motor : {false, true}) {
    Joint joint{GearedServo({.gain_per_rad = 12, .play_rad = play, .friction_nm = 0.02, .encoder_at_motor = at_motor})};
    const auto settled = [&](double load) {
      joint.load_nm = load;
      joint.run(towards(0), 2);
      return std::pair(joint.q, joint.servo.encoder_rad(joint.q));
    };
    const auto [low, low_seen] = settled(-0.4);
    const auto [high, high_seen] = settled(0.4);
    const double spring = 2 * 0.4 / (4.1 * 12);
    EXPECT_NEAR(high_seen - low_seen, spring, 1e-4) << "what the drive sees is its spring's way";
    if (at_motor) {
      EXPECT_NEAR(high - low, spring + 2 * play, 1e-4) << "an encoder at the motor does not see the play";
    } else {
      EXPECT_NEAR(high - low, spring, 1e-4) << "one at the joint corrects it";
    }
  }
}

TEST(ServoOfAJoint, ReadsItsEncoderInSteps) {
  const double step = 2 * math::kPi / 4096;
  const GearedServo servo({.encoder_step_rad = step});
  for (const double q : {-1.0, 0.1, 0.7654321}) {
    const double seen = servo.encoder_rad(q);
    EXPECT_LE(math::fabs(seen - q), step / 2 + 1e-12);
    EXPECT_NEAR(seen / step, math::round(seen / step), 1e-9);
  }
}

TEST(ServoOfAJoint, GetsWarmByItsTorque) {
  Joint joint{GearedServo({})};
  EXPECT_EQ(joint.servo.temperature_c(), 25);
  joint.load_nm = -2;
  joint.run(towards(0.2), 600);
  EXPECT_NEAR(joint.servo.temperature_c(), 25 + 6 * 2 * 2, 1) << "after five time constants";
}

TEST(ServoOfAJoint, IsNotLedAstrayByNonsense) {
  Joint joint{GearedServo({.play_rad = 0.004, .friction_nm = 0.05, .encoder_step_rad = 0.0015})};
  for (const double bad : {math::kNan, math::kInf, -math::kInf}) {
    joint.run({DriveMode::position, bad}, 0.1);
    joint.run({DriveMode::impedance, bad, bad, bad, bad, bad}, 0.1);
    joint.run({DriveMode::velocity, 0, bad}, 0.1);
    EXPECT_TRUE(math::is_finite(joint.q) && math::is_finite(joint.v)) << bad;
    EXPECT_LE(math::fabs(joint.v), 4.9);
  }
}

}  // namespace
}  // namespace sinew::plant::servo_test
