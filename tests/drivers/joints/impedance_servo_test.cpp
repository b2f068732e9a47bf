// Behaviour that only motors with gains in their frames have: MIT and CyberGear.
#include "servo_rig.hpp"

namespace sinew::drivers::impedance_servo_test {
namespace {

using msg::JointMode;

class Impedance : public testing::TestWithParam<Protocol> {
 protected:
  void build(const ServoConfig& c) {
    rig = std::make_unique<ServoRig>();
    motor = &rig->add(GetParam(), c);
    rig->configure();
    ASSERT_TRUE(rig->until(0, JointMode::enabled));
  }
  static ServoConfig plain() { return ServoRig::plain(GetParam(), 3); }
  std::unique_ptr<ServoRig> rig;
  sim_hil::SimServo* motor = nullptr;
};

TEST_P(Impedance, VelocityAndEffortAreModesToo) {
  ServoConfig c = plain();
  c.mode = ServoMode::velocity;
  build(c);
  rig->setpoint[0] = 1;
  rig->run(500ms);
  EXPECT_NEAR(rig->joints[0]->velocity_radps(), 1, 0.1);
  c.mode = ServoMode::effort;
  build(c);
  rig->setpoint[0] = 0.1;
  rig->run(1s);
  EXPECT_NEAR(rig->sample.effort_nm[0], 0.1, 0.01);
  EXPECT_NEAR(rig->joints[0]->velocity_radps(), 2, 0.2);
}

TEST_P(Impedance, DampSlowsDownAndDoesNotHold) {
  ServoConfig c = plain();
  c.stop = StopAction::damp;
  build(c);
  rig->setpoint[0] = 2;
  rig->run(100ms);
  ASSERT_GT(rig->joints[0]->velocity_radps(), 0.8);
  rig->run(300ms, false);
  EXPECT_EQ(rig->sample.mode[0], JointMode::stopping);
  EXPECT_TRUE(motor->live());
  EXPECT_LT(std::abs(rig->joints[0]->velocity_radps()), 0.05);
  rig->joints[0]->place(-0.2);
  rig->run(300ms, false);
  EXPECT_NEAR(rig->joints[0]->position_rad(), -0.2, 0.05) << "nothing pulls it back";
}

TEST_P(Impedance, AfterDampingItGoesOnFromWhereItSagged) {
  ServoConfig c = plain();
  c.limits = {-3, 3, 1, 20};
  c.kd = 0.5;
  c.stop = StopAction::damp;
  build(c);
  rig->run(500ms, false);
  ASSERT_EQ(rig->sample.mode[0], JointMode::stopping);
  for (int i = 1; i <= 100; ++i) {  // slowly, by its weight
    rig->joints[0]->place(-0.005 * i);
    rig->run(10ms, false);
  }
  rig->setpoint[0] = 2;
  rig->run(50ms);
  EXPECT_EQ(rig->sample.mode[0], JointMode::enabled);
  EXPECT_LT(rig->joints[0]->position_rad(), -0.4) << "1 rad/s at most";
  EXPECT_GT(rig->joints[0]->position_rad(), -0.51);
}

TEST_P(Impedance, HoldPullsBack) {
  ServoConfig c = plain();
  c.stop = StopAction::hold;
  build(c);
  rig->setpoint[0] = 0.4;
  rig->run(2s);
  rig->run(1s, false);
  EXPECT_EQ(rig->sample.mode[0], JointMode::stopping);
  EXPECT_NEAR(rig->joints[0]->position_rad(), 0.4, 0.02);
}

TEST_P(Impedance, EffortLimitHoldsAgainstTheSpring) {
  ServoConfig c = plain();
  c.limits.effort_nm = 0.3;
  c.following.position_rad = 0;
  build(c);
  rig->setpoint[0] = 2.5;
  double most = 0;
  for (int i = 0; i < 300; ++i) {
    rig->run(1ms);
    most = std::max(most, std::abs(motor->effort_nm()));
  }
  EXPECT_LT(most, 0.36) << "60 N m/rad * 2.5 rad would be 150";
  EXPECT_GT(most, 0.2);
}

/// Something hangs on it.
class HeavyJoint final : public sim_hil::SimJoint {
 public:
  explicit HeavyJoint(double load_nm) : load_nm_(load_nm) {}
  double position_rad() const override { return model_.position_rad(); }
  double velocity_radps() const override { return model_.velocity_radps(); }
  void set_effort(double nm) override { model_.set_effort(nm - load_nm_); }
  void advance(Duration dt) override { model_.advance(dt); }

 private:
  double load_nm_;
  sim_hil::JointModel model_;
};

TEST_P(Impedance, SpringThatCarriesItsLoadIsNoOverload) {
  ServoConfig c = plain();
  c.kp = 12;
  c.kd = 1;
  c.limits.effort_nm = 9.5;
  rig = std::make_unique<ServoRig>();
  HeavyJoint joint(9);
  rig->add_driver(GetParam(), c, 0);
  rig->add_sim(GetParam(), c, joint);
  rig->configure();
  ASSERT_TRUE(rig->until(0, JointMode::enabled));
  rig->setpoint[0] = 0;
  rig->run(5s);
  EXPECT_LT(joint.position_rad(), -0.7) << "9 N m over 12 N m/rad";
  EXPECT_EQ(rig->group().servo(0).stats().faults, 0u);
  EXPECT_EQ(rig->group().servo(0).stats().enables, 1u);
  rig.reset();  // before its joint
}

TEST_P(Impedance, WhatItCannotDoIsSaidBeforeTheStart) {
  const auto check = [](const ServoConfig& c) {
    return to_string(GetParam() == Protocol::cybergear ? check_cybergear(c, 0xFD)
                                                       : check_mit(c, ServoRig::mit(GetParam())));
  };
  ServoConfig c = plain();
  EXPECT_EQ(check(c), "");
  c.stop = StopAction::quick_stop;
  EXPECT_EQ(check(c), "on_stop: \"torque_off\", \"damp\" or \"hold\"; this motor has no quick_stop");
  c = plain();
  c.kp = 900;
  EXPECT_EQ(check(c), "kp: a number above 0, at most 500; required for mode position");
  c = plain();
  c.node_id = 200;
  EXPECT_EQ(check(c), GetParam() == Protocol::ak80     ? ""
                      : GetParam() == Protocol::damiao ? "id: an integer from 1 to 15, for this motor"
                                                       : "id: an integer from 1 to 127");
  c = plain();
  c.sign = 0;
  EXPECT_EQ(check(c), "reversed: a sign of 1 or -1");
}

TEST_P(Impedance, MotorStopsByItselfWhenNobodySpeaksToIt) {
  ServoConfig c = plain();
  if (GetParam() == Protocol::cybergear) c.device_timeout = 100ms;  // the others have it set in the motor
  build(c);                                                         // the CyberGear's is told before it is enabled
  ASSERT_TRUE(motor->live());
  for (int i = 0; i < 400; ++i) {  // the hub is not stepped any more
    rig->os.clock.set(rig->os.now() + 500us);
    rig->bus[0]->sims.poll(rig->os.now());
  }
  EXPECT_FALSE(motor->live());
}

INSTANTIATE_TEST_SUITE_P(Servo, Impedance, testing::Values(Protocol::ak80, Protocol::damiao, Protocol::cybergear),
                         [](const auto& param) { return std::string(name_of(param.param)); });

TEST(CyberGearServo, TellsItsSerialNumberAndVoltage) {
  ServoRig rig;
  rig.add(Protocol::cybergear, ServoRig::plain(Protocol::cybergear, 3)).voltage_v = 36.5;
  rig.configure();
  rig.run(2s);
  EXPECT_EQ(rig.group().servo(0).identity().serial, 0xC0FFEEu);
  EXPECT_NEAR(rig.sample.voltage_v[0], 36.5, 0.01);
}

}  // namespace
}  // namespace sinew::drivers::impedance_servo_test
