// The results of a pilot's switches and sticks.
#include "robots/quad/pilot_switch.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "robots/quad/mission.hpp"
#include "rt/exec/module_rig.hpp"

namespace sinew::control::pilot_switch_test {
namespace {

using namespace std::chrono_literals;
using msg::Time;
using rt::StepStatus;

msg::NavState nav_at(Time t) {
  msg::NavState n;
  n.stamp = t;
  n.attitude_valid = n.height_valid = n.position_valid = 1;
  n.p_world_m.z = n.height_m = 2;
  n.q_world_base = math::Quat::from_yaw_pitch_roll({0.5, 0, 0}).to<msg::Quat>();
  return n;
}

class PilotSwitchTest : public ::testing::Test {
 protected:
  /// One step 5 ms later, with the inputs that are set.
  StepStatus step() {
    now = now + 5ms;
    if (hears) {
      rc.stamp = now;
      rig.put("rc", rc);
    }
    if (has_state) rig.put("state", nav_at(now));
    if (mission_flies) {
      mission.stamp = now;
      rig.put("mission", mission);
    }
    return rig.step(now, 5ms);
  }
  const msg::PilotSwitches& switches() { return *rig.get<msg::PilotSwitches>("switches"); }
  /// The output of this step; null: none.
  const msg::AttitudeSetpoint* attitude() {
    const auto all = rig.all<msg::AttitudeSetpoint>("attitude");
    return all.empty() ? nullptr : all.back();
  }
  math::YawPitchRoll angles() { return math::Quat(attitude()->q_world_base).yaw_pitch_roll(); }

  PilotSwitchTest() {
    rc.count = 16;
    rc.channel[4] = rc.channel[5] = -1;
    rc.link_quality = 0.9;
    mission.thrust_n = 11;
    mission.armed = 1;
  }
  void take_over() { rc.channel[4] = 1; }

  PilotSwitch module;
  rt::ModuleRig rig{module};
  msg::RcSample rc;
  msg::AttitudeSetpoint mission;
  bool hears = true, has_state = true, mission_flies = true;
  Time now{1'000'000'000};
};

TEST_F(PilotSwitchTest, TheMissionsSetpointPassesAsItIs) {
  mission.q_world_base = math::Quat::from_yaw_pitch_roll({1, 0.1, -0.2}).to<msg::Quat>();
  ASSERT_EQ(step(), StepStatus::ok);
  ASSERT_TRUE(attitude());
  EXPECT_EQ(attitude()->q_world_base, mission.q_world_base);
  EXPECT_EQ(attitude()->thrust_n, 11);
  EXPECT_EQ(attitude()->stamp, mission.stamp);
  EXPECT_EQ(switches().lost, 0u);
  EXPECT_EQ(switches().take_over, 0u);
  EXPECT_EQ(switches().link_quality, 0.9);
}

TEST_F(PilotSwitchTest, SticksFlyAfterTakingOver) {
  step();
  take_over();
  rc.channel[0] = 0.5;  // right
  rc.channel[1] = 1;    // forward
  ASSERT_EQ(step(), StepStatus::ok);
  ASSERT_TRUE(attitude());
  EXPECT_EQ(switches().take_over, 1u);
  EXPECT_NEAR(angles().roll, 0.225, 1e-9) << "leans right";
  EXPECT_NEAR(angles().pitch, 0.45, 1e-9) << "nose down";
  EXPECT_NEAR(angles().yaw, 0.5, 1e-9) << "as it looked when taken over";
  EXPECT_NEAR(attitude()->thrust_n, 1.2 * 9.80665, 1e-9) << "the throttle's middle carries the weight";
  EXPECT_EQ(attitude()->armed, 1u);
}

TEST_F(PilotSwitchTest, ThrottleGoesFromLeastToMostThrust) {
  take_over();
  rc.channel[2] = -1;
  step();
  EXPECT_NEAR(attitude()->thrust_n, 1, 1e-9);
  rc.channel[2] = 1;
  step();
  EXPECT_NEAR(attitude()->thrust_n, 20, 1e-9);
  rc.channel[2] = 0.04;
  step();
  EXPECT_NEAR(attitude()->thrust_n, 1.2 * 9.80665, 1e-9) << "a hand that trembles";
}

TEST_F(PilotSwitchTest, TheYawStickTurnsClockwise) {
  take_over();
  rc.channel[3] = 1;
  for (int i = 0; i < 100; ++i) step();
  EXPECT_NEAR(angles().yaw, 0.5 - 1.5 * 0.5, 1e-6);
}

TEST_F(PilotSwitchTest, TheKillSwitchIsToldAndStaysWhenTheLinkIsLost) {
  rc.channel[5] = 1;
  step();
  EXPECT_EQ(switches().kill, 1u);
  hears = false;
  for (int i = 0; i < 100; ++i) step();
  EXPECT_EQ(switches().lost, 1u);
  EXPECT_EQ(switches().kill, 1u);
  hears = true;
  rc.channel[5] = -1;
  step();
  EXPECT_EQ(switches().kill, 0u);
}

TEST_F(PilotSwitchTest, SilenceOrAReceiverWithoutTransmitterIsALostLink) {
  step();
  hears = false;
  for (int i = 0; i < 59; ++i) step();
  EXPECT_EQ(switches().lost, 0u) << "295 ms";
  step(), step();
  EXPECT_EQ(switches().lost, 1u);
  EXPECT_EQ(switches().link_quality, 0);
  hears = true;
  step();
  EXPECT_EQ(switches().lost, 0u);
  rc.lost = 1;
  step();
  EXPECT_EQ(switches().lost, 1u);
}

TEST_F(PilotSwitchTest, WithoutALinkTheMissionFliesOn) {
  take_over();
  step();
  rc.lost = 1;
  step();
  EXPECT_EQ(switches().take_over, 0u);
  EXPECT_EQ(attitude()->thrust_n, 11);
}

TEST_F(PilotSwitchTest, NobodyIsHeardBeforeTheFirstSample) {
  hears = false;
  ASSERT_EQ(step(), StepStatus::ok);
  EXPECT_EQ(switches().lost, 1u);
  EXPECT_EQ(attitude()->thrust_n, 11) << "whether that may fly is the guardian's matter";
}

TEST_F(PilotSwitchTest, NobodyStartsFromTheGroundByHand) {
  mission.armed = 0;
  take_over();
  rc.channel[2] = 1;
  step();
  EXPECT_EQ(attitude()->armed, 0u);
  mission.armed = 1;  // as long as the pilot has it, this stays so
  step();
  EXPECT_EQ(attitude()->armed, 0u);
}

TEST_F(PilotSwitchTest, ThePilotsMotorsStayArmedWhenTheMissionGivesUp) {
  step();
  take_over();
  step();
  mission.armed = 0;
  step();
  EXPECT_EQ(attitude()->armed, 1u);
  mission_flies = false;
  for (int i = 0; i < 100; ++i) step();
  ASSERT_TRUE(attitude());
  EXPECT_EQ(attitude()->armed, 1u);
}

TEST_F(PilotSwitchTest, WithoutAStateNobodyFlies) {
  has_state = false;
  take_over();
  EXPECT_EQ(step(), StepStatus::ok);
  EXPECT_FALSE(attitude()) << "neither pilot nor mission: the lease runs out";
  EXPECT_EQ(switches().take_over, 1u) << "but the switches are told";
}

TEST_F(PilotSwitchTest, NonsenseOnAChannelIsAStickInTheMiddle) {
  take_over();
  rc.channel[0] = std::numeric_limits<double>::quiet_NaN();
  rc.channel[1] = 50;
  step();
  EXPECT_EQ(angles().roll, 0);
  EXPECT_EQ(angles().pitch, 0);
  rc.count = 4;  // a short receiver has no switches
  step();
  EXPECT_EQ(switches().take_over, 0u);
}

TEST_F(PilotSwitchTest, ChannelsAreTheUsersChoice) {
  rt::ModuleRig other(module);
  other.set("kill_channel", std::int64_t{9});
  rc.channel[8] = 1;
  rc.stamp = now;
  other.put("rc", rc);
  ASSERT_EQ(other.step(now, 5ms), StepStatus::ok);
  EXPECT_EQ(other.get<msg::PilotSwitches>("switches")->kill, 1u);
}

TEST(MissionStandBy, WhatWasFlyingComesDownAfterwards) {
  MissionPlan plan;
  Time now{};
  msg::NavState nav;
  const auto step = [&](int ms, bool by_hand) {
    for (int i = 0; i < ms; i += 5) {
      now = now + 5ms;
      nav = nav_at(now);
      if (by_hand)
        plan.stand_by(now, nav);
      else
        plan.step(now, nav, 0.005);
    }
  };
  step(3000, true);
  EXPECT_EQ(plan.state().phase, msg::MissionPhase::wait) << "on the ground it waits";
  EXPECT_EQ(plan.setpoint().armed, 0u);
  step(3000, false);
  ASSERT_GE(plan.state().phase, msg::MissionPhase::climb);
  step(60'000, true);
  EXPECT_EQ(plan.state().phase, msg::MissionPhase::abort);
  EXPECT_EQ(plan.setpoint().armed, 1u) << "longer than any of its limits";
  EXPECT_NEAR(plan.setpoint().yaw_rad, 0.5, 1e-9);
  step(100, false);
  EXPECT_EQ(plan.state().phase, msg::MissionPhase::abort);
  EXPECT_EQ(plan.setpoint().armed, 1u);
  EXPECT_LT(plan.setpoint().v_world_mps.z, 0) << "sinks";
}

}  // namespace
}  // namespace sinew::control::pilot_switch_test
