// Behaviour that only CiA 402 drives have.
#include <cmath>
#include <cstring>

#include "servo_rig.hpp"

namespace sinew::drivers::cia402_servo_test {
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
  EXPECT_GE(drive->object(wire::kHeartbeatProducer), 100u);
  EXPECT_LT(drive->object(wire::kHeartbeatProducer), 150u);
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

TEST_F(Cia402, DisarmedInTheMiddleOfAQuickStopItIsWithoutTorqueAtOnce) {
  ServoConfig c = plain();
  c.mode = ServoMode::velocity;
  c.stop = StopAction::quick_stop;
  build(c);
  rig->setpoint[0] = 3;
  ASSERT_TRUE(rig->until(0, JointMode::enabled));
  rig->run(300ms);
  rig->write(1ms);
  ASSERT_TRUE(rig->until(0, JointMode::stopping, false));
  ASSERT_TRUE(drive->live()) << "it brakes";
  ASSERT_TRUE(rig->group().stop());
  rig->run(6ms, false);
  EXPECT_FALSE(drive->live());
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

/// A drive that has its switch at `home_rad`.
sim_hil::SimCia402::Parameters with_switch(double home_rad) {
  sim_hil::SimCia402::Parameters p;
  p.node_id = 5;
  p.home_rad = home_rad;
  return p;
}

TEST_F(Cia402, HomesByItselfBeforeItFollowsAnything) {
  ServoConfig c = plain();
  c.homing_method = 1;
  build(c, with_switch(-0.8));
  rig->setpoint[0] = 0.2;
  ASSERT_TRUE(rig->until(0, JointMode::homing));
  for (int i = 0; i < 10'000 && rig->sample.mode[0] == JointMode::homing; ++i) {
    EXPECT_EQ(rig->sample.ready, 0u);
    ASSERT_LT(rig->joints[0]->position_rad(), 0.01) << "it goes to its switch, not to its setpoint";
    rig->run(1ms);
  }
  ASSERT_EQ(rig->sample.mode[0], JointMode::enabled);
  EXPECT_EQ(drive->object(wire::kModeOfOperation), 8u);
  EXPECT_NEAR(rig->joints[0]->position_rad(), -0.8, 0.05);
  rig->run(3s);
  EXPECT_NEAR(rig->sample.position_rad[0], 0.2, 0.02);
  EXPECT_NEAR(rig->joints[0]->position_rad(), -0.6, 0.03) << "0.2 from its switch";
  EXPECT_EQ(rig->group().servo(0).stats().faults, 0u);
  EXPECT_EQ(rig->group().servo(0).stats().losses, 0u);
}

TEST_F(Cia402, HomesAgainWhenItIsAskedTo) {
  ServoConfig c = plain();
  c.homing_method = 1;
  build(c, with_switch(-0.8));
  ASSERT_TRUE(rig->until(0, JointMode::enabled));
  rig->run(3s);
  rig->group().request(0, ServoCommand::Request::home);
  ASSERT_TRUE(rig->until(0, JointMode::homing));
  ASSERT_TRUE(rig->until(0, JointMode::enabled));
  rig->setpoint[0] = 0.2;
  rig->run(3s);
  EXPECT_NEAR(rig->joints[0]->position_rad(), -0.6, 0.03);
}

TEST_F(Cia402, PowerThatWasAwayTakesHomingAnewAndAFaultDoesNot) {
  ServoConfig c = plain();
  c.homing_method = 1;
  build(c, with_switch(-0.3));
  ASSERT_TRUE(rig->until(0, JointMode::enabled));
  drive->fail(0x3220);
  ASSERT_TRUE(rig->until(0, JointMode::fault));
  for (int i = 0; i < 10'000 && rig->sample.mode[0] != JointMode::enabled; ++i) {
    ASSERT_NE(rig->sample.mode[0], JointMode::homing);
    rig->run(1ms);
  }
  drive->power(false);
  rig->run(200ms);
  drive->power(true);
  EXPECT_TRUE(rig->until(0, JointMode::homing));
  EXPECT_TRUE(rig->until(0, JointMode::enabled));
}

TEST_F(Cia402, GapOfTheBusIsNoLossOfPowerAndTakesNoHoming) {
  ServoConfig c = plain();
  c.homing_method = 1;
  build(c, with_switch(-0.3));
  rig->setpoint[0] = 0.2;
  ASSERT_TRUE(rig->until(0, JointMode::enabled));
  rig->run(2s);
  for (int gap = 0; gap < 3; ++gap) {  // also after one of before
    rig->bus[0]->wire.lose([](const msg::CanFrame&) { return true; });
    ASSERT_TRUE(rig->until(0, JointMode::absent));
    rig->run(300ms);
    rig->bus[0]->wire.lose(nullptr);
    for (int i = 0; i < 10'000 && rig->sample.mode[0] != JointMode::enabled; ++i) {
      ASSERT_NE(rig->sample.mode[0], JointMode::homing);
      rig->run(1ms);
    }
    ASSERT_EQ(rig->sample.mode[0], JointMode::enabled);
    rig->run(1s);
    EXPECT_NEAR(rig->joints[0]->position_rad(), -0.1, 0.03) << "0.2 from its switch, as before";
  }
}

TEST_F(Cia402, PowerThatWasLostInAGapOfTheBusTakesHomingAnew) {
  ServoConfig c = plain();
  c.homing_method = 1;
  build(c, with_switch(-0.3));
  ASSERT_TRUE(rig->until(0, JointMode::enabled));
  rig->run(1s);
  rig->bus[0]->wire.lose([](const msg::CanFrame&) { return true; });
  ASSERT_TRUE(rig->until(0, JointMode::absent));
  drive->power(false);
  rig->run(100ms);
  drive->power(true);  // and its boot-up message is lost
  rig->run(300ms);
  rig->bus[0]->wire.lose(nullptr);
  EXPECT_TRUE(rig->until(0, JointMode::homing));
  EXPECT_TRUE(rig->until(0, JointMode::enabled));
}

TEST_F(Cia402, ADriveThatTakesNoMarkHomesAfterEachGap) {
  ServoConfig c = plain();
  c.homing_method = 1;
  auto p = with_switch(-0.3);
  p.refuses = {wire::kHeartbeatProducer};
  build(c, p);
  ASSERT_TRUE(rig->until(0, JointMode::enabled));
  rig->bus[0]->wire.lose([](const msg::CanFrame&) { return true; });
  ASSERT_TRUE(rig->until(0, JointMode::absent));
  rig->bus[0]->wire.lose(nullptr);
  EXPECT_TRUE(rig->until(0, JointMode::homing));
}

TEST_F(Cia402, HomingThatIsInterruptedLeavesTheDriveInItsModeAndBeginsAgain) {
  ServoConfig c = plain();
  c.homing_method = 1;
  build(c, with_switch(-2.8));
  ASSERT_TRUE(rig->until(0, JointMode::homing));
  rig->run(30ms);
  ASSERT_TRUE(rig->group().stop());
  rig->run(100ms, false);
  EXPECT_FALSE(drive->live());
  EXPECT_EQ(drive->object(wire::kModeOfOperation), 8u);
  EXPECT_TRUE(rig->until(0, JointMode::homing));
  EXPECT_TRUE(rig->until(0, JointMode::enabled));
}

TEST_F(Cia402, HomingEndsWithItsLeaseEvenWhereStoppingMeansHolding) {
  ServoConfig c = plain();
  c.homing_method = 1;
  c.stop = StopAction::hold;
  build(c, with_switch(-2.8));
  ASSERT_TRUE(rig->until(0, JointMode::homing));
  rig->run(30ms);
  ASSERT_TRUE(drive->live());
  rig->run(150ms, false);
  EXPECT_FALSE(drive->live());
  EXPECT_GT(rig->joints[0]->position_rad(), -2.5) << "on its way";
}

TEST_F(Cia402, DriveThatFallsSilentWhileItHomesIsLost) {
  ServoConfig c = plain();
  c.homing_method = 1;
  build(c, with_switch(-2.8));
  ASSERT_TRUE(rig->until(0, JointMode::homing));
  rig->run(100ms);
  ASSERT_TRUE(drive->live());
  drive->faults.silent = true;
  rig->run(100ms);
  EXPECT_EQ(rig->sample.mode[0], JointMode::absent);
  EXPECT_EQ(rig->group().servo(0).stats().losses, 1u);
}

/// In the cyclic modes bits 12 and 10 mean other things, and are set.
void set_homed_bits(msg::CanFrame& frame) { frame.data[1] |= 0x14; }
bool is_status(const msg::CanFrame& frame) { return frame.id == wire::tpdo_id(1, 5); }

TEST_F(Cia402, BitsOfTheModeOfBeforeAreNotTakenForHomed) {
  ServoConfig c = plain();
  c.homing_method = 1;
  build(c, with_switch(-0.8));
  int slow = 0;  // answers until the drive is in mode 6
  rig->bus[0]->bus.tamper = [&](msg::CanFrame& frame) {
    const bool asked = drive->object(wire::kModeOfOperation) == 6;
    if (is_status(frame) && (!asked || slow < 20)) set_homed_bits(frame);
    const auto sdo = wire::decode_sdo_reply(frame);
    if (asked && frame.id == wire::sdo_reply_id(5) && sdo && sdo->object == wire::kModeDisplay && slow < 20) {
      frame.data[4] = 8;
    }
    if (asked && is_status(frame)) ++slow;
  };
  ASSERT_TRUE(rig->until(0, JointMode::homing));
  ASSERT_TRUE(rig->until(0, JointMode::enabled));
  EXPECT_NEAR(rig->joints[0]->position_rad(), -0.8, 0.05);
}

TEST_F(Cia402, HomingThatIsAskedForIsNotTakenForTheOneBefore) {
  ServoConfig c = plain();
  c.homing_method = 1;
  build(c, with_switch(-0.3));
  ASSERT_TRUE(rig->until(0, JointMode::enabled));
  rig->setpoint[0] = 0.8;
  rig->run(3s);
  int late = 0;  // statuswords until it takes the bits back
  rig->bus[0]->bus.tamper = [&](msg::CanFrame& frame) {
    if (!is_status(frame) || drive->object(wire::kModeOfOperation) != 6 || late > 20) return;
    set_homed_bits(frame);
    if ((drive->object(wire::kControlword) & 0x10) != 0) ++late;
  };
  rig->setpoint[0] = 0;
  rig->group().request(0, ServoCommand::Request::home);
  ASSERT_TRUE(rig->until(0, JointMode::homing));
  ASSERT_TRUE(rig->until(0, JointMode::enabled));
  EXPECT_NEAR(rig->joints[0]->position_rad(), -0.3, 0.05);
}

TEST_F(Cia402, DriveThatSaysInModeSixThatItIsHomedDoesNotMoveForIt) {
  ServoConfig c = plain();
  c.homing_method = 1;
  build(c, with_switch(-0.8));
  rig->bus[0]->bus.tamper = [&](msg::CanFrame& frame) {
    if (is_status(frame) && drive->object(wire::kModeOfOperation) == 6) set_homed_bits(frame);
  };
  ASSERT_TRUE(rig->until(0, JointMode::homing));
  ASSERT_TRUE(rig->until(0, JointMode::enabled));
  EXPECT_NEAR(rig->joints[0]->position_rad(), 0, 0.01);
}

TEST_F(Cia402, WithoutAnEffortLimitTheDrivesOwnStays) {
  ServoConfig c = plain();
  c.limits.effort_nm = ServoLimits{}.effort_nm;
  build(c);
  rig->setpoint[0] = 0.5;
  ASSERT_TRUE(rig->until(0, JointMode::enabled));
  rig->run(3s);
  EXPECT_EQ(drive->object(wire::rpdo_mapping(1, 0)), 2u);
  EXPECT_EQ(drive->object(wire::kMaxTorque), 1000u) << "as it was set";
  EXPECT_NEAR(rig->joints[0]->position_rad(), 0.5, 0.02);

  c.limits.effort_nm = 1;
  build(c);
  ASSERT_TRUE(rig->until(0, JointMode::enabled));
  EXPECT_EQ(drive->object(wire::kMaxTorque), 500u) << "1 of its 2 N m";

  c.limits.effort_nm = ServoLimits{}.effort_nm;
  c.derating = {50, 70};
  EXPECT_EQ(to_string(check_cia402(c, {})),
            "max_effort_nm: a number above 0; required with derate_start_c and derate_end_c");
}

TEST_F(Cia402, DriveWithoutARatedTorqueIsAFaultUntilTheRobotFileHasIt) {
  sim_hil::SimCia402::Parameters p;
  p.node_id = 5;
  p.rated_nm = 1e-4;  // 0 thousandths of a newton metre
  ServoConfig c = plain();
  c.mode = ServoMode::effort;
  build(c, p);
  ASSERT_TRUE(rig->until(0, JointMode::fault));
  EXPECT_EQ(rig->sample.fault_code[0], 0x6076u);
  EXPECT_FALSE(drive->live());
  c.rated_effort_nm = 2;
  build(c, p);
  EXPECT_TRUE(rig->until(0, JointMode::enabled));
}

TEST_F(Cia402, CycleTimeIsExactOrRefused) {
  const auto check = [](double hz) { return to_string(check_cia402(plain(), {.tick_hz = hz})); };
  for (const double hz : {1.0, 25.0, 50.0, 100.0, 125.0, 200.0, 250.0, 400.0, 500.0, 800.0, 1000.0, 2000.0, 4000.0}) {
    EXPECT_EQ(check(hz), "") << hz;
  }
  EXPECT_EQ(check(300),
            "bus.tick_hz: with cia402 on it a rate whose period 60C2h holds, 1 to 255 times a power of ten seconds: "
            "100, 125, 200, 250, 400, 500, 800, 1000, 2000 and such");
  EXPECT_NE(check(30), "");
  const auto cycle_of = [this](double hz) {
    rig = std::make_unique<ServoRig>(CanHubConfig{.name = "can0", .tick_hz = hz, .max_load = 10});
    ServoConfig c = plain();
    c.feedback_timeout = 1s;
    drive = dynamic_cast<sim_hil::SimCia402*>(&rig->add(Protocol::cia402, c));
    rig->configure();
    EXPECT_TRUE(rig->until(0, JointMode::enabled));
    const auto exponent = static_cast<std::int8_t>(drive->object(wire::kInterpolationExponent));
    return drive->object(wire::kInterpolationTime) * std::pow(10.0, exponent);
  };
  EXPECT_DOUBLE_EQ(cycle_of(4000), 0.00025);
  EXPECT_DOUBLE_EQ(cycle_of(25), 0.04);
}

TEST_F(Cia402, OptionalObjectsMayBeMissing) {
  sim_hil::SimCia402::Parameters p;
  p.node_id = 5;
  p.refuses = {wire::kAbortOption,           wire::kQuickStopOption, wire::kInterpolationTime,
               wire::kInterpolationExponent, wire::kSerialNumber,    wire::kHeartbeatProducer};
  build(plain(), p);
  EXPECT_TRUE(rig->until(0, JointMode::enabled));
}

TEST_F(Cia402, DriveWithoutAVoltageHasAllTheRest) {
  sim_hil::SimCia402::Parameters p;
  p.node_id = 5;
  p.refuses = {wire::kDcLinkVoltage};
  ServoConfig c = plain();
  c.mode = ServoMode::velocity;
  build(c, p);
  rig->setpoint[0] = 1;
  ASSERT_TRUE(rig->until(0, JointMode::enabled));
  rig->run(500ms);
  EXPECT_EQ(drive->object(wire::tpdo_mapping(2, 0)), 1u);
  EXPECT_NEAR(rig->sample.velocity_radps[0], 1, 0.1) << "TPDO2 without its second half";
  EXPECT_TRUE(std::isnan(rig->sample.voltage_v[0]));
  EXPECT_EQ(rig->group().servo(0).stats().malformed, 0u);
}

TEST_F(Cia402, DriveThatHasNoPlaceForWhatMovesItIsAFault) {
  sim_hil::SimCia402::Parameters p;
  p.node_id = 5;
  p.refuses = {wire::kTargetPosition};
  build(plain(), p);
  ASSERT_TRUE(rig->until(0, JointMode::fault));
  EXPECT_EQ(rig->sample.fault_code[0], static_cast<std::uint32_t>(wire::SdoAbort::cannot_be_mapped));
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
  EXPECT_EQ(to_string(check_cia402(c, o)), "");
  c.stop = StopAction::damp;
  EXPECT_EQ(to_string(check_cia402(c, o)), "on_stop: \"torque_off\", \"quick_stop\" or \"hold\"; CiA 402 has no damp");
  c = plain();
  c.counts_per_turn = 0;
  EXPECT_EQ(to_string(check_cia402(c, o)), "counts_per_turn: a number above 0; it is required");
  c = plain();
  c.node_id = 126;
  EXPECT_EQ(to_string(check_cia402(c, o)), "id: another number than the bus's master_node");
  c = plain();
  c.limits.position_min_rad = 5;
  EXPECT_EQ(to_string(check_cia402(c, o)), "max_rad: a number above min_rad, 5");
  c = plain();
  for (const int method : {0, 1, 14, 17, 30, 33, 37, -1, -128}) EXPECT_TRUE(is_homing_method(method)) << method;
  for (const int method : {15, 16, 31, 32, 36, 38, 99, -129}) {
    c.homing_method = method;
    EXPECT_EQ(to_string(check_cia402(c, o)),
              "homing_method: 0 (none), 1 to 14, 17 to 30, 33 to 35, 37, or -128 to -1 (the maker's own)");
  }
}

}  // namespace
}  // namespace sinew::drivers::cia402_servo_test
