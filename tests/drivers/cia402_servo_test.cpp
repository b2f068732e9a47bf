// What only CiA 402 drives do.
#include <cstring>

#include "servo_rig.hpp"

namespace sinew::drivers {
namespace {

using msg::JointMode;

class Cia402 : public testing::Test {
 protected:
  void build(const ServoConfig& c) {
    rig = std::make_unique<ServoRig>();
    drive = dynamic_cast<sim_hil::SimCia402*>(&rig->add(Protocol::cia402, c));
    rig->configure();
  }
  /// A drive that is made by hand, to refuse objects and the like.
  void build(const ServoConfig& c, const sim_hil::SimCia402::Parameters& p) {
    rig = std::make_unique<ServoRig>();
    rig->joints.push_back(std::make_unique<sim_hil::JointModel>());
    rig->add_driver(Protocol::cia402, c, 0);
    drive = &rig->bus[0]->sims.add<sim_hil::SimCia402>(*rig->joints[0], sim_hil::SimMount{}, p);
    rig->configure();
  }
  static ServoConfig plain() { return ServoRig::plain(Protocol::cia402, 5); }
  std::unique_ptr<ServoRig> rig;
  sim_hil::SimCia402* drive = nullptr;
};

TEST_F(Cia402, IsIdentifiedAndItsNameReadInSegments) {
  build(plain());
  ASSERT_TRUE(rig->until(0, JointMode::enabled));
  const ServoIdentity& id = rig->group().servo(0).identity();
  EXPECT_TRUE(id.known);
  EXPECT_EQ(id.vendor, 0x51u);
  EXPECT_EQ(id.product, 0x402u);
  EXPECT_EQ(id.serial, 1001u);
  EXPECT_STREQ(id.name, "Simulated drive 402");
}

TEST_F(Cia402, IsConfiguredAsTheRobotFileSays) {
  ServoConfig c = plain();
  c.device_timeout = 50ms;
  c.stop = StopAction::quick_stop;
  build(c);
  ASSERT_TRUE(rig->until(0, JointMode::enabled));
  EXPECT_EQ(drive->nmt(), wire::NmtState::operational);
  EXPECT_EQ(drive->object(wire::kModeOfOperation), 8u);
  EXPECT_EQ(drive->object(wire::kHeartbeatConsumer), 126u << 16 | 50u);
  EXPECT_EQ(drive->object(wire::kHeartbeatProducer), 100u);
  EXPECT_EQ(drive->object(wire::kAbortOption), 3u);
  EXPECT_EQ(drive->object(wire::kInterpolationTime), 20u) << "2 ms in steps of 0.1 ms";
  EXPECT_EQ(drive->object(wire::rpdo_communication(1, 1)), 0x205u);
  EXPECT_NEAR(rig->sample.voltage_v[0], 24, 0.01);
}

TEST_F(Cia402, DriveStopsByItselfWhenTheMasterDies) {
  ServoConfig c = plain();
  c.device_timeout = 50ms;
  build(c);
  ASSERT_TRUE(rig->until(0, JointMode::enabled));
  ASSERT_TRUE(drive->live());
  for (int i = 0; i < 200; ++i) {  // the hub is not stepped any more
    rig->os.clock.set(rig->os.now() + 500us);
    rig->bus[0]->sims.poll(rig->os.now());
  }
  EXPECT_FALSE(drive->live());
}

TEST_F(Cia402, VelocityAndEffortAreModesToo) {
  ServoConfig c = plain();
  c.mode = ServoMode::velocity;
  build(c);
  rig->setpoint[0] = 1;
  ASSERT_TRUE(rig->until(0, JointMode::enabled));
  rig->run(500ms);
  EXPECT_EQ(drive->object(wire::kModeOfOperation), 9u);
  EXPECT_NEAR(rig->joints[0]->velocity_radps(), 1, 0.05);
  rig->run(5s);
  EXPECT_LT(rig->joints[0]->position_rad(), 3.1) << "at its limit it goes no further";

  c.mode = ServoMode::effort;
  build(c);
  rig->setpoint[0] = 0.1;
  ASSERT_TRUE(rig->until(0, JointMode::enabled));
  rig->run(1s);
  EXPECT_EQ(drive->object(wire::kModeOfOperation), 10u);
  EXPECT_NEAR(rig->sample.effort_nm[0], 0.1, 0.005);
  EXPECT_NEAR(rig->joints[0]->velocity_radps(), 2, 0.1) << "0.1 N m against 0.05 N m s of friction";
}

TEST_F(Cia402, QuickStopBrakesAndEndsWithoutTorque) {
  ServoConfig c = plain();
  c.mode = ServoMode::velocity;
  c.stop = StopAction::quick_stop;
  build(c);
  rig->setpoint[0] = 3;
  ASSERT_TRUE(rig->until(0, JointMode::enabled));
  rig->run(300ms);
  ASSERT_GT(rig->joints[0]->velocity_radps(), 2);
  rig->write(1ms);
  ASSERT_TRUE(rig->until(0, JointMode::stopping, false));
  rig->run(80ms, false);
  EXPECT_LT(std::abs(rig->joints[0]->velocity_radps()), 0.1);
  EXPECT_EQ(drive->state(), wire::DriveState::switch_on_disabled);
  EXPECT_EQ(rig->sample.mode[0], JointMode::disabled);
  EXPECT_TRUE(rig->until(0, JointMode::enabled)) << "and it comes back";
}

TEST_F(Cia402, HoldStaysWhereItIs) {
  ServoConfig c = plain();
  c.stop = StopAction::hold;
  build(c);
  rig->setpoint[0] = 0.5;
  ASSERT_TRUE(rig->until(0, JointMode::enabled));
  rig->run(2s);
  rig->setpoint[0] = 2;
  rig->run(2s, false);
  EXPECT_EQ(rig->sample.mode[0], JointMode::stopping);
  EXPECT_TRUE(drive->live());
  EXPECT_NEAR(rig->joints[0]->position_rad(), 0.5, 0.02);
}

TEST_F(Cia402, HomesAndGoesOnFromThere) {
  ServoConfig c = plain();
  c.homing_method = 1;
  build(c, [] {
    sim_hil::SimCia402::Parameters p;
    p.node_id = 5;
    p.home_rad = -0.8;
    return p;
  }());
  ASSERT_TRUE(rig->until(0, JointMode::enabled));
  rig->group().request(0, ServoCommand::Request::home);
  ASSERT_TRUE(rig->until(0, JointMode::homing));
  ASSERT_TRUE(rig->until(0, JointMode::enabled));
  rig->setpoint[0] = 0.2;
  rig->run(3s);
  EXPECT_NEAR(rig->sample.position_rad[0], 0.2, 0.02);
  EXPECT_NEAR(rig->joints[0]->position_rad(), -0.6, 0.03) << "0.2 from its switch";
  EXPECT_EQ(rig->group().servo(0).stats().faults, 0u);
}

TEST_F(Cia402, HomingThatIsInterruptedLeavesTheDriveInItsMode) {
  ServoConfig c = plain();
  c.homing_method = 1;
  build(c, [] {
    sim_hil::SimCia402::Parameters p;
    p.node_id = 5;
    p.home_rad = -2.8;
    return p;
  }());
  ASSERT_TRUE(rig->until(0, JointMode::enabled));
  rig->group().request(0, ServoCommand::Request::home);
  ASSERT_TRUE(rig->until(0, JointMode::homing));
  rig->run(30ms);
  ASSERT_TRUE(rig->group().stop());
  rig->run(100ms, false);
  EXPECT_FALSE(drive->live());
  EXPECT_EQ(drive->object(wire::kModeOfOperation), 8u);
  EXPECT_TRUE(rig->until(0, JointMode::enabled));
}

TEST_F(Cia402, OptionalObjectsMayBeMissing) {
  sim_hil::SimCia402::Parameters p;
  p.node_id = 5;
  p.refuses = {wire::kAbortOption,           wire::kQuickStopOption, wire::kInterpolationTime,
               wire::kInterpolationExponent, wire::kSerialNumber,    wire::kHeartbeatProducer};
  build(plain(), p);
  EXPECT_TRUE(rig->until(0, JointMode::enabled));
}

TEST_F(Cia402, DriveThatRefusesItsConfigurationIsAFaultWithTheAbortCode) {
  sim_hil::SimCia402::Parameters p;
  p.node_id = 5;
  p.refuses = {wire::kModeOfOperation};
  build(plain(), p);
  ASSERT_TRUE(rig->until(0, JointMode::fault));
  EXPECT_EQ(rig->sample.fault_code[0], static_cast<std::uint32_t>(wire::SdoAbort::no_object));
  rig->run(5s);
  EXPECT_LT(rig->group().servo(0).stats().restarts, 20u);
}

TEST_F(Cia402, EmergencyNamesTheFault) {
  build(plain());
  ASSERT_TRUE(rig->until(0, JointMode::enabled));
  drive->fault_stays = true;
  drive->fail(0x3220);
  ASSERT_TRUE(rig->until(0, JointMode::fault));
  EXPECT_NE(rig->sample.faults[0] & msg::kJointUnderVoltage, 0u);
  EXPECT_EQ(rig->sample.fault_code[0], 0x3220u);
  rig->run(5s);
  EXPECT_NE(rig->sample.mode[0], JointMode::enabled);
  drive->fault_stays = false;
  EXPECT_TRUE(rig->until(0, JointMode::enabled));
}

TEST_F(Cia402, DriveThatRestartsIsConfiguredAgain) {
  build(plain());
  ASSERT_TRUE(rig->until(0, JointMode::enabled));
  drive->power(false);
  drive->power(true);  // within its time-out
  rig->run(20ms);
  EXPECT_NE(rig->sample.mode[0], JointMode::enabled);
  EXPECT_TRUE(rig->until(0, JointMode::enabled));
  EXPECT_EQ(drive->nmt(), wire::NmtState::operational);
}

TEST_F(Cia402, WhatItCannotDoIsSaidBeforeTheStart) {
  const Cia402Options o;
  ServoConfig c = plain();
  EXPECT_EQ(check_cia402(c, o), "");
  c.stop = StopAction::damp;
  EXPECT_EQ(check_cia402(c, o), "servo 'joint5': stop: CiA 402 has torque_off, quick_stop and hold");
  c = plain();
  c.counts_per_turn = 0;
  EXPECT_EQ(check_cia402(c, o), "servo 'joint5': counts_per_turn: above 0");
  c = plain();
  c.node_id = 126;
  EXPECT_EQ(check_cia402(c, o), "servo 'joint5': node_id: is that of the master");
  c = plain();
  c.limits.position_min_rad = 5;
  EXPECT_EQ(check_cia402(c, o), "servo 'joint5': limits: position_min_rad below position_max_rad");
}

}  // namespace
}  // namespace sinew::drivers
