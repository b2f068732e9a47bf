#include "control/attitude_law.hpp"

#include <gmock/gmock.h>

#include "control/rotor_allocation.hpp"
#include "test_world.hpp"

namespace sinew::control::attitude_law_test {
namespace {

using math::Quat;
using math::Vec3;

msg::NavState state(const Quat& q, const Vec3& gyro = {}) {
  msg::NavState n;
  n.q_world_base = q.to<msg::Quat>();
  n.gyro_radps = gyro.to<msg::Vec3>();
  n.attitude_valid = 1;
  return n;
}

msg::AttitudeSetpoint setpoint(const Quat& q, double thrust_n = 11.8) {
  msg::AttitudeSetpoint s;
  s.q_world_base = q.to<msg::Quat>();
  s.thrust_n = thrust_n;
  s.armed = 1;
  return s;
}

struct StepResponse {
  double rise_s = 0;      // to 90 %
  double overshoot = 0;   // share of the step
  double left_over = 0;   // share of the step, after two seconds
  double other_axes = 0;  // largest turn about them, rad
};

/// The vehicle hovers high up and is asked to turn by `angle` about `axis`.
StepResponse respond(const Vec3& axis, double angle) {
  test::QuadModelOptions o;
  o.noise = 0;
  o.p_start_m = {0, 0, 50};
  test::QuadModel world(o);
  AttitudeLaw law;
  const RotorParams rotors;
  std::array<double, 4> command{0.49, 0.49, 0.49, 0.49};
  const Quat wanted = Quat::from_axis_angle(axis, angle);
  StepResponse r;
  for (int ms = 0; ms < 2500; ++ms) {
    for (int k = 0; k < 4; ++k) world.step(command);
    const test::Truth t = world.truth();
    const Quat goal = ms < 500 ? Quat{} : wanted;
    const auto wrench = law.step(state(t.q_world_base, t.gyro_radps), setpoint(goal), 0.001);
    command = allocate(Vec3(wrench.torque_nm), wrench.thrust_n, rotors).command;
    if (ms < 500) continue;
    const Vec3 turned = t.q_world_base.log();
    const double along = dot(turned, axis) / angle;
    if (r.rise_s == 0 && along > 0.9) r.rise_s = 0.001 * (ms - 499);
    r.overshoot = std::max(r.overshoot, along - 1);
    r.other_axes = std::max(r.other_axes, norm(turned - axis * dot(turned, axis)));
    r.left_over = math::fabs(along - 1);
  }
  return r;
}

TEST(AttitudeLaw, RollStepRisesFastAndHardlyOvershoots) {
  const StepResponse r = respond({1, 0, 0}, 0.3);
  EXPECT_GT(r.rise_s, 0.05);
  EXPECT_LT(r.rise_s, 0.35);
  EXPECT_LT(r.overshoot, 0.10);
  EXPECT_LT(r.left_over, 0.02);
  EXPECT_LT(r.other_axes, 0.01);
}

TEST(AttitudeLaw, PitchStepRisesFastAndHardlyOvershoots) {
  const StepResponse r = respond({0, 1, 0}, -0.3);
  EXPECT_LT(r.rise_s, 0.35);
  EXPECT_LT(r.overshoot, 0.10);
  EXPECT_LT(r.left_over, 0.02);
}

TEST(AttitudeLaw, YawStepArrivesWithoutTilting) {
  const StepResponse r = respond({0, 0, 1}, 0.8);
  EXPECT_LT(r.rise_s, 1.2);
  EXPECT_LT(r.overshoot, 0.10);
  EXPECT_LT(r.other_axes, 0.02);
}

TEST(AttitudeLaw, TakesTheShortWayRound) {
  const AttitudeLaw law;
  const Quat almost_round = Quat::from_axis_angle({0, 0, 1}, 2 * math::kPi - 0.1);
  EXPECT_LT(law.rate_setpoint({}, almost_round).z, 0);
  const Vec3 same = law.rate_setpoint({}, -Quat{});
  EXPECT_NEAR(norm(same), 0, 1e-12) << "q and -q are one attitude";
}

TEST(AttitudeLaw, UpsideDownStillGivesAFiniteTurn) {
  AttitudeLaw law;
  const auto wrench = law.step(state(Quat{0, 1, 0, 0}), setpoint({}), 0.001);
  EXPECT_TRUE(is_finite(Vec3(wrench.torque_nm)));
  EXPECT_GT(norm(Vec3(wrench.torque_nm)), 0.1);
}

TEST(AttitudeLaw, DisarmedGivesNoTorqueAndForgetsItsIntegral) {
  AttitudeLaw law;
  const Quat tilted = Quat::from_axis_angle({1, 0, 0}, 0.2);
  for (int i = 0; i < 1000; ++i) law.step(state(tilted), setpoint({}), 0.001);
  msg::AttitudeSetpoint off = setpoint({});
  off.armed = 0;
  EXPECT_EQ(law.step(state(tilted), off, 0.001).torque_nm, msg::Vec3{});
  AttitudeLaw fresh;
  EXPECT_EQ(law.step(state(tilted), setpoint({}), 0.001).torque_nm,
            fresh.step(state(tilted), setpoint({}), 0.001).torque_nm);
}

}  // namespace
}  // namespace sinew::control::attitude_law_test
