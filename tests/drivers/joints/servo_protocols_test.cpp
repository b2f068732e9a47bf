// The rules for every servo protocol, each with its simulated servo and a healthy neighbour on the same bus.
#include "servo_rig.hpp"

namespace sinew::drivers::servo_protocols_test {
namespace {

using msg::JointMode;

class EveryProtocol : public testing::TestWithParam<Protocol> {
 protected:
  /// Two joints: the one under test, and a neighbour that has to stay well.
  void SetUp() override { build(ServoRig::plain(GetParam(), 1)); }
  void build(const ServoConfig& c) {
    rig = std::make_unique<ServoRig>();
    servo = &rig->add(GetParam(), c);
    neighbour = &rig->add(GetParam(), ServoRig::plain(GetParam(), 2));
    rig->configure();
  }
  void enable() {
    ASSERT_TRUE(rig->until(0, JointMode::enabled));
    ASSERT_TRUE(rig->until(1, JointMode::enabled));
  }
  void expect_neighbour_well() {
    const ServoStats& stats = rig->group().servo(1).stats();
    EXPECT_EQ(stats.losses, 0u);
    EXPECT_EQ(stats.faults, 0u);
    EXPECT_EQ(stats.enables, 1u);
    EXPECT_EQ(rig->sample.mode[1], JointMode::enabled);
    EXPECT_TRUE(neighbour->live());
  }
  const msg::JointState& now() const { return rig->sample; }
  const ServoStats& stats() const { return rig->group().servo(0).stats(); }

  std::unique_ptr<ServoRig> rig;
  sim_hil::SimServo *servo = nullptr, *neighbour = nullptr;
};

TEST_P(EveryProtocol, WithoutACommandItAnswersAndHasNoTorque) {
  rig->run(2s, false);
  EXPECT_EQ(now().mode[0], JointMode::disabled);
  EXPECT_EQ(now().ready, 0u);
  EXPECT_GT(now().measured[0].ns, 0);
  EXPECT_FALSE(servo->live());
  EXPECT_EQ(stats().losses, 0u);
}

TEST_P(EveryProtocol, FollowsAPositionAndMeasuresIt) {
  enable();
  rig->setpoint[0] = 0.7;
  rig->run(3s);
  EXPECT_NEAR(rig->joints[0]->position_rad(), 0.7, 0.02);
  EXPECT_NEAR(now().position_rad[0], rig->joints[0]->position_rad(), 0.005);
  EXPECT_NEAR(now().velocity_radps[0], 0, 0.05);
  EXPECT_NEAR(now().temperature_c[0], 25, 0.5);
  EXPECT_EQ(now().ready, 3u);
  EXPECT_EQ(now().faults[0], 0u);
  expect_neighbour_well();
}

TEST_P(EveryProtocol, JointFrameHasItsSignGearAndZero) {
  ServoConfig c = ServoRig::plain(GetParam(), 1);
  c.sign = -1;
  c.gear_ratio = 2;
  c.zero_rad = 0.3;
  build(c);
  enable();
  rig->setpoint[0] = -0.5;
  rig->run(3s);
  EXPECT_NEAR(rig->joints[0]->position_rad(), -0.5, 0.02);
  EXPECT_NEAR(now().position_rad[0], rig->joints[0]->position_rad(), 0.005);
}

TEST_P(EveryProtocol, SetpointsAreKeptWithinLimits) {
  ServoConfig c = ServoRig::plain(GetParam(), 1);
  c.limits = {-0.4, 0.4, 0.5, 2};
  build(c);
  enable();
  rig->setpoint[0] = 3;
  rig->run(400ms);
  EXPECT_LT(rig->joints[0]->position_rad(), 0.26) << "0.5 rad/s at most";
  rig->run(3s);
  EXPECT_NEAR(rig->joints[0]->position_rad(), 0.4, 0.02);
  ServoFeedback said;
  ASSERT_TRUE(rig->groups[0]->feedback_of(0, said));
  EXPECT_GT(said.beyond, hal::Duration(3s)) << "and says for how long it was asked for more";
  rig->setpoint[0] = 0.4;
  rig->run(20ms);
  ASSERT_TRUE(rig->groups[0]->feedback_of(0, said));
  EXPECT_EQ(said.beyond, hal::Duration{});
}

TEST_P(EveryProtocol, TimeThatPassesUntilItIsEnabledIsNoLeaveToJump) {
  ServoConfig c = ServoRig::plain(GetParam(), 1);
  c.limits = {-3, 3, 1, 20};  // strong and quick enough to show a jump
  c.kd = 0.5;
  c.feedback_timeout = 2s;
  build(c);
  rig->run(2s, false);
  ASSERT_EQ(now().mode[0], JointMode::disabled);
  servo->faults.silent = true;  // its brake is slow, and it says nothing meanwhile
  rig->setpoint[0] = 2;
  rig->run(300ms);
  ASSERT_NE(now().mode[0], JointMode::enabled);
  servo->faults.silent = false;
  ASSERT_TRUE(rig->until(0, JointMode::enabled));
  rig->run(50ms);
  EXPECT_LT(rig->joints[0]->position_rad(), 0.1) << "1 rad/s at most, from the moment on in which it is enabled";
  rig->run(3s);
  EXPECT_NEAR(rig->joints[0]->position_rad(), 2, 0.03);
}

TEST_P(EveryProtocol, TimeInWhichItHoldsIsNoLeaveToJump) {
  ServoConfig c = ServoRig::plain(GetParam(), 1);
  c.limits = {-3, 3, 1, 20};
  c.kd = 0.5;
  c.stop = StopAction::hold;
  build(c);
  enable();
  rig->run(2s, false);
  ASSERT_EQ(now().mode[0], JointMode::stopping);
  rig->setpoint[0] = 2;
  rig->run(52ms);
  EXPECT_EQ(now().mode[0], JointMode::enabled);
  EXPECT_LT(rig->joints[0]->position_rad(), 0.1);
  EXPECT_GT(rig->joints[0]->position_rad(), 0);
}

TEST_P(EveryProtocol, LeaseThatRunsOutTakesTheTorqueAndANewCommandBringsItBack) {
  enable();
  rig->run(150ms, false);  // the lease was 100 ms
  EXPECT_FALSE(servo->live());
  EXPECT_EQ(now().mode[0], JointMode::disabled);
  EXPECT_TRUE(rig->until(0, JointMode::enabled));
  EXPECT_EQ(stats().enables, 2u);
}

TEST_P(EveryProtocol, StopTakesTheTorqueAtOnce) {
  enable();
  ASSERT_TRUE(rig->group().stop());
  rig->run(10ms, false);
  EXPECT_FALSE(servo->live());
}

TEST_P(EveryProtocol, SingleLostFramesAreNoFault) {
  enable();
  servo->faults.lost = 0.05;
  rig->setpoint[0] = 0.5;
  rig->run(5s);
  EXPECT_GT(stats().missed, 10u);
  EXPECT_EQ(stats().losses, 0u);
  EXPECT_EQ(stats().faults, 0u);
  EXPECT_EQ(stats().enables, 1u);
  EXPECT_NEAR(rig->joints[0]->position_rad(), 0.5, 0.03);
}

TEST_P(EveryProtocol, SilentServoIsAbsentAndComesBackByAFreshCommand) {
  enable();
  servo->power(false);
  rig->run(200ms);
  EXPECT_EQ(now().mode[0], JointMode::absent);
  EXPECT_NE(now().faults[0] & msg::kJointLost, 0u);
  EXPECT_EQ(stats().losses, 1u);
  EXPECT_EQ(now().ready, 2u);
  expect_neighbour_well();

  rig->write(1h);  // a command from before it is back
  servo->power(true);
  rig->run(6s, false);
  EXPECT_EQ(now().mode[0], JointMode::disabled) << "it answers again, and an old command does not enable it";
  EXPECT_EQ(now().faults[0] & msg::kJointLost, 0u);
  EXPECT_FALSE(servo->live());
  EXPECT_TRUE(rig->until(0, JointMode::enabled));
  expect_neighbour_well();
}

TEST_P(EveryProtocol, ServoThatIsNotThereIsLookedForUntilItComes) {
  servo->power(false);
  rig->run(5s);
  EXPECT_EQ(now().mode[0], JointMode::absent);
  EXPECT_EQ(now().measured[0].ns, 0);
  EXPECT_GT(stats().restarts, 2u);
  EXPECT_LT(stats().restarts, 20u) << "with growing pauses";
  expect_neighbour_well();
  servo->power(true);
  EXPECT_TRUE(rig->until(0, JointMode::enabled));
  expect_neighbour_well();
}

TEST_P(EveryProtocol, GarbageIsCountedAndDisturbsNobody) {
  enable();
  servo->faults.garbage = true;
  rig->run(2s);
  EXPECT_GT(stats().malformed + stats().implausible, 20u);
  EXPECT_NE(now().mode[0], JointMode::enabled);
  EXPECT_TRUE(std::isfinite(now().position_rad[0]));
  EXPECT_LT(std::abs(now().position_rad[0]), 13);
  expect_neighbour_well();
  servo->faults.garbage = false;
  rig->run(5s);
  EXPECT_TRUE(rig->until(0, JointMode::enabled));
  expect_neighbour_well();
}

TEST_P(EveryProtocol, StuckServoIsAnOverload) {
  enable();
  rig->run(100ms);
  servo->faults.stuck = true;
  rig->setpoint[0] = 1.5;
  ASSERT_TRUE(rig->until(0, JointMode::fault));
  EXPECT_NE(now().faults[0] & msg::kJointOverload, 0u);
  EXPECT_EQ(now().ready, 2u);
  rig->run(8s);
  EXPECT_GT(stats().enables, 2u);
  EXPECT_LT(stats().enables, 10u) << "tried again, with growing pauses";
  expect_neighbour_well();
  servo->faults.stuck = false;
  rig->run(6s);
  EXPECT_NEAR(rig->joints[0]->position_rad(), 1.5, 0.03);
  EXPECT_EQ(now().faults[0], 0u);
}

TEST_P(EveryProtocol, FaultOfTheDriveIsNamedAndItComesBackWhenItsCauseIsGone) {
  enable();
  servo->temperature_c = 130;  // more than any of them bears
  ASSERT_TRUE(rig->until(0, JointMode::fault));
  EXPECT_NE(now().faults[0] & msg::kJointOverTemperature, 0u);
  EXPECT_NE(now().fault_code[0], 0u);
  EXPECT_FALSE(servo->live());
  EXPECT_EQ(now().ready, 2u);
  expect_neighbour_well();
  servo->temperature_c = 30;
  EXPECT_TRUE(rig->until(0, JointMode::enabled));
  EXPECT_EQ(now().faults[0], 0u);
  expect_neighbour_well();
}

TEST_P(EveryProtocol, WarmthTakesEffortBeforeTheDriveGivesUp) {
  ServoConfig c = ServoRig::plain(GetParam(), 1);
  c.derating = {50, 70};
  c.following.position_rad = 0;
  build(c);
  enable();
  servo->temperature_c = 60;
  rig->run(1500ms);  // CiA 402's is asked for once a second
  EXPECT_NE(now().faults[0] & msg::kJointDerated, 0u);
  EXPECT_EQ(now().ready, 3u) << "a warm joint is a ready one";
  rig->setpoint[0] = 2.5;
  double most = 0;
  for (int i = 0; i < 400; ++i) {
    rig->run(1ms);
    most = std::max(most, std::abs(servo->effort_nm()));
  }
  EXPECT_LT(most, 1.15) << "half of 2 N m, and what lies between two answers";
  EXPECT_GT(most, 0.5);
}

TEST_P(EveryProtocol, JointThatIsTooWarmToFollowIsNoOverload) {
  ServoConfig c = ServoRig::plain(GetParam(), 1);
  c.derating = {50, 70};
  build(c);
  enable();
  servo->temperature_c = 75;
  rig->run(1500ms);
  rig->setpoint[0] = 2.5;
  rig->run(3s);
  EXPECT_LT(rig->joints[0]->position_rad(), 0.5) << "it has no effort left";
  EXPECT_EQ(now().mode[0], JointMode::enabled);
  EXPECT_EQ(now().faults[0], std::uint32_t{msg::kJointDerated});
  EXPECT_EQ(stats().enables, 1u);
}

TEST_P(EveryProtocol, TwoWithOneNumberAreFound) {
  sim_hil::JointModel other;
  rig->add_sim(GetParam(), ServoRig::plain(GetParam(), 1), other);
  rig->run(6s);
  EXPECT_NE(now().faults[0] & msg::kJointDuplicate, 0u);
  EXPECT_EQ(now().ready, 2u);
  EXPECT_FALSE(servo->live());
  expect_neighbour_well();
}

TEST_P(EveryProtocol, ZeroHereMovesTheFrame) {
  enable();
  rig->setpoint[0] = 0.5;
  rig->run(2s);
  rig->setpoint[0] = 0;
  rig->group().request(0, ServoCommand::Request::zero_here);
  rig->run(1s);
  EXPECT_NEAR(now().position_rad[0], 0, 0.02);
  EXPECT_NEAR(rig->joints[0]->position_rad(), 0.5, 0.03) << "where it was is zero now";
  EXPECT_NEAR(rig->group().servo(0).config().zero_rad, 0.5, 0.03) << "to be saved";
}

TEST_P(EveryProtocol, SpoofedFeedbackStaysWithinWhatAJointCanDo) {
  enable();
  sim_hil::MemoryCanPort& liar = rig->bus[0]->wire.attach();
  sim_hil::JointModel elsewhere;
  elsewhere.place(2.0);
  sim_hil::SimServos liars(liar);
  double worst = 0;
  // Frames of a correct form with other contents: another servo's, of the same number, at another place.
  for (int i = 0; i < 200; ++i) {
    rig->run(1ms);
    msg::CanFrame frame;
    if (GetParam() == Protocol::cia402) {
      frame = wire::can_frame(wire::tpdo_id(1, 1), 8);
      wire::put_le(frame, 0, std::uint16_t{0x0637});
      wire::put_le(frame, 2, std::int32_t{21000});
    } else if (GetParam() == Protocol::cybergear) {
      frame = wire::encode_cybergear_feedback({1, 0xFD, 2.0, 0, 0, 30, 0, 0, wire::CyberGearFeedback::Mode::running});
    } else {
      wire::MitFeedback f;
      f.motor = 1;
      f.position_rad = 2.0;
      f.code = GetParam() == Protocol::damiao ? 1 : 0;
      frame = wire::encode_mit_reply(0, f, ServoRig::mit(GetParam()).type);
    }
    if (i % 8 == 0) (void)liar.send(frame, hal::kNever);
    worst = std::max(worst, std::abs(now().position_rad[0]));
  }
  EXPECT_GT(stats().implausible, 10u);
  EXPECT_LT(worst, 0.3);
  EXPECT_TRUE(servo->live());
  expect_neighbour_well();
}

INSTANTIATE_TEST_SUITE_P(Servo, EveryProtocol,
                         testing::Values(Protocol::cia402, Protocol::ak80, Protocol::damiao, Protocol::cybergear),
                         [](const auto& param) { return std::string(name_of(param.param)); });

}  // namespace
}  // namespace sinew::drivers::servo_protocols_test
