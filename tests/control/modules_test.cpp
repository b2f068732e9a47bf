// The modules around the pure classes: what they publish, and when they publish nothing.
#include <gmock/gmock.h>

#include "control/attitude_controller.hpp"
#include "control/error_state_filter.hpp"
#include "control/magnetic_model.hpp"
#include "control/mixer.hpp"
#include "control/position_controller.hpp"
#include "robots/quad/mission.hpp"
#include "rt/exec/module_rig.hpp"

namespace sinew::control::modules_test {
namespace {

using namespace std::chrono_literals;
using msg::Time;
using rt::ModuleRig;
using rt::StepStatus;

constexpr std::int64_t kMs = 1'000'000;

msg::ImuSample still(std::int64_t ns) {
  msg::ImuSample s;
  s.stamp = {ns};
  s.accel_mps2 = {0, 0, 9.81};
  return s;
}

msg::NavState good_state(std::int64_t ns) {
  msg::NavState n;
  n.stamp = {ns};
  n.attitude_valid = n.height_valid = n.position_valid = 1;
  n.p_world_m.z = n.height_m = 1;
  return n;
}

/// A filter that has stood still for a second.
struct StandingFilter {
  ErrorStateFilter filter;
  ModuleRig rig{filter};
  std::int64_t ns = 0;

  explicit StandingFilter(int steps = 1000) {
    for (int i = 0; i < steps; ++i) step();
  }
  StepStatus step() {
    ns += kMs;
    rig.put("imu", still(ns));
    return rig.step({ns}, 1ms);
  }
};

TEST(ErrorStateFilter, IsStaleUntilTheFirstAttitudeAndThenPublishesEachSample) {
  StandingFilter f(0);
  EXPECT_EQ(f.step(), StepStatus::stale);
  EXPECT_EQ(f.rig.get<msg::NavState>("state"), nullptr);
  for (int i = 0; i < 500; ++i) f.step();
  ASSERT_EQ(f.step(), StepStatus::ok);
  EXPECT_EQ(f.rig.get<msg::NavState>("state")->stamp, Time{f.ns});
}

TEST(ErrorStateFilter, IsStaleWithoutANewSample) {
  StandingFilter f;
  EXPECT_EQ(f.rig.step({f.ns + kMs}, 1ms), StepStatus::stale);
  EXPECT_EQ(f.rig.get<msg::NavState>("state"), nullptr);
  EXPECT_EQ(f.step(), StepStatus::ok);
}

TEST(ErrorStateFilter, SampleThatIsNotANumberIsAFaultAndNothingIsPublished) {
  StandingFilter f;
  msg::ImuSample bad = still(f.ns += kMs);
  bad.accel_mps2.x = math::kNan;
  f.rig.put("imu", bad);
  EXPECT_EQ(f.rig.step({f.ns}, 1ms), StepStatus::fault);
  EXPECT_EQ(f.rig.get<msg::NavState>("state"), nullptr);
  ASSERT_EQ(f.step(), StepStatus::ok) << "the next good one is used again";
  EXPECT_TRUE(math::is_finite(f.rig.get<msg::NavState>("state")->q_world_base.w));
}

TEST(ErrorStateFilter, OneGoodSampleOfACycleIsEnough) {
  StandingFilter f;
  msg::ImuSample bad = still(f.ns + kMs / 2);
  bad.gyro_radps.z = math::kInf;
  f.rig.put("imu", bad);
  EXPECT_EQ(f.step(), StepStatus::ok);
}

TEST(ErrorStateFilter, RangeThatArrivesWithoutAnInertialSampleIsStillUsed) {
  StandingFilter f;
  msg::RangeSample range;
  range.stamp = {f.ns};
  range.range_m = 0.5;
  f.rig.put("range", range);
  EXPECT_EQ(f.rig.step({f.ns}, 1ms), StepStatus::stale);
  ASSERT_EQ(f.step(), StepStatus::ok);
  EXPECT_NEAR(f.rig.get<msg::NavState>("state")->height_m, 0.54, 0.01);
}

TEST(ErrorStateFilter, TurningMotorsEndRest) {
  StandingFilter f;
  ASSERT_TRUE(f.rig.get<msg::NavState>("state")->at_rest);
  msg::ActuatorCommand motors;
  motors.armed = 1;
  f.rig.put("motors", motors);
  ASSERT_EQ(f.step(), StepStatus::ok);
  EXPECT_FALSE(f.rig.get<msg::NavState>("state")->at_rest);
}

TEST(ErrorStateFilter, NeedsNothingButInertialSamples) {
  ErrorStateFilter filter;
  ModuleRig rig(filter);
  for (const char* port : {"range", "baro", "pad", "motors"}) rig.leave_unbound(port);
  StepStatus last = StepStatus::stale;
  for (std::int64_t ns = kMs; ns < 1000 * kMs; ns += 5 * kMs) {
    rig.put("imu", still(ns));
    last = rig.step({ns}, 5ms);
  }
  EXPECT_EQ(last, StepStatus::ok);
}

TEST(ErrorStateFilter, ResetForgetsEverythingButTheParameters) {
  StandingFilter f;
  f.rig.set("max_gap_s", 0.5);
  f.rig.reset();
  EXPECT_EQ(f.step(), StepStatus::stale);
  EXPECT_EQ(f.filter.estimator().params.max_gap_s, 0.5);
  EXPECT_FALSE(f.filter.estimator().started());
}

/// Three IMUs on one vehicle that stands in the open; some of them go wrong.
struct ManyImus {
  ErrorStateFilter filter;
  ModuleRig rig{filter};
  std::int64_t ns = 0;
  std::int64_t count;
  std::array<double, 3> turn_radps{};  // what an IMU reads too much
  std::array<bool, 3> silent{};
  msg::NavReport last;
  msg::NavState state;

  explicit ManyImus(std::int64_t imus) : count(imus) {
    rig.set("imus", imus);
    if (imus < 3) rig.leave_unbound("imu3");
    run(3);
  }
  StepStatus run(double seconds) {
    StepStatus status = StepStatus::stale;
    for (const std::int64_t end = ns + static_cast<std::int64_t>(seconds * 1e9); ns < end;) {
      ns += kMs;
      const char* const ports[] = {"imu", "imu2", "imu3"};
      for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
        msg::ImuSample s = still(ns);
        s.gyro_radps.z = turn_radps[i];
        if (!silent[i]) rig.put(ports[i], s);
      }
      if (ns % (200 * kMs) == 0) {
        msg::GnssSample fix;
        fix.stamp = {ns};
        fix.latitude_deg = 47, fix.longitude_deg = 8;
        fix.horizontal_accuracy_m = fix.vertical_accuracy_m = 1, fix.speed_accuracy_mps = 0.2;
        fix.fix = msg::GnssFix::full;
        rig.put("gnss", fix);
      }
      if (ns % (20 * kMs) == 0) {
        msg::MagSample mag;  // it looks to the south-west, so the first heading is a turn
        mag.stamp = {ns};
        mag.field_t =
            math::Quat::from_axis_angle({0, 0, 1}, 2.0).rotate(earth_field_t({47, 8, 0}, 2026).value()).to<msg::Vec3>();
        rig.put("mag", mag);
      }
      status = rig.step({ns}, 1ms);
      if (const auto* r = rig.get<msg::NavReport>("report")) last = *r;
      if (const auto* n = rig.get<msg::NavState>("state")) state = *n;
    }
    return status;
  }
  double yaw() const { return math::Quat(state.q_world_base).yaw(); }
};

TEST(ErrorStateFilter, OfThreeImusTheOneThatTurnsAloneIsOutvotedAndTheChangeIsAnnounced) {
  ManyImus f(3);
  const double yaw = f.yaw();
  EXPECT_EQ(f.last.imu, 0U);
  const std::uint32_t resets = f.last.resets;
  f.turn_radps[0] = 1;
  EXPECT_EQ(f.run(0.5), StepStatus::ok);
  EXPECT_NE(f.last.imu, 0U);
  EXPECT_GT(f.last.resets, resets);
  EXPECT_EQ(f.last.reset_cause, msg::NavResetCause::imu_change);
  EXPECT_NEAR(f.yaw(), yaw, 0.01) << "half a turn of nothing";
  EXPECT_NEAR(f.last.reset_yaw_rad, -0.1, 0.05) << "taken back: a tenth of a second of it";
}

TEST(ErrorStateFilter, AnImuThatFallsSilentIsReplacedAndWithoutASecondOneTheStateIsStale) {
  ManyImus f(2);
  f.silent[0] = true;
  EXPECT_EQ(f.run(0.5), StepStatus::ok);
  EXPECT_EQ(f.last.imu, 1U);
  EXPECT_EQ(f.state.stamp, Time{f.ns});
  f.silent[1] = true;
  EXPECT_EQ(f.run(0.1), StepStatus::stale);
}

TEST(ErrorStateFilter, OfTwoImusTheOneWhoseEstimateFitsIsTaken) {
  ManyImus f(2);
  const double yaw = f.yaw();
  f.turn_radps[0] = 0.3;  // the magnetometer and its own estimate drift apart
  EXPECT_EQ(f.run(20), StepStatus::ok);
  EXPECT_EQ(f.last.imu, 1U);
  EXPECT_NEAR(f.yaw(), yaw, 0.03);
}

TEST(PositionController, PublishesAnAttitudeFromAFreshStateAndSetpoint) {
  PositionController controller;
  ModuleRig rig(controller);
  msg::FlightSetpoint wanted;
  wanted.stamp = {100 * kMs};
  wanted.p_world_m = {0, 0, 1};
  wanted.mode = msg::FlightMode::position;
  wanted.armed = 1;
  rig.put("setpoint", wanted);
  EXPECT_EQ(rig.step({100 * kMs}, 5ms), StepStatus::stale) << "no state";
  rig.put("state", good_state(100 * kMs));
  ASSERT_EQ(rig.step({101 * kMs}, 5ms), StepStatus::ok);
  EXPECT_NEAR(rig.get<msg::AttitudeSetpoint>("attitude")->thrust_n, 1.2 * 9.81, 1e-6);
  EXPECT_EQ(rig.step({150 * kMs}, 5ms), StepStatus::stale) << "a state of 50 ms ago";
}

TEST(PositionController, SetpointThatIsNotANumberIsAFault) {
  PositionController controller;
  ModuleRig rig(controller);
  msg::FlightSetpoint wanted;
  wanted.p_world_m = {math::kNan, 0, 1};
  wanted.mode = msg::FlightMode::position;
  wanted.armed = 1;
  rig.put("setpoint", wanted);
  rig.put("state", good_state(0));
  EXPECT_EQ(rig.step({kMs}, 5ms), StepStatus::fault);
  EXPECT_EQ(rig.get<msg::AttitudeSetpoint>("attitude"), nullptr);
}

TEST(AttitudeController, IsStaleWithoutAValidAttitudeOrAFreshSetpoint) {
  AttitudeController controller;
  ModuleRig rig(controller);
  msg::AttitudeSetpoint wanted;
  wanted.thrust_n = 10;
  wanted.armed = 1;
  rig.put("attitude", wanted);
  msg::NavState state = good_state(kMs);
  state.attitude_valid = 0;
  rig.put("state", state);
  EXPECT_EQ(rig.step({kMs}, 1ms), StepStatus::stale);
  rig.put("state", good_state(2 * kMs));
  ASSERT_EQ(rig.step({2 * kMs}, 1ms), StepStatus::ok);
  EXPECT_EQ(rig.get<msg::WrenchSetpoint>("wrench")->stamp, Time{2 * kMs}) << "of the measurement";
  rig.put("state", good_state(60 * kMs));
  EXPECT_EQ(rig.step({60 * kMs}, 1ms), StepStatus::stale) << "the setpoint is 60 ms old";
}

TEST(AttitudeController, WhatIsNotANumberIsAFault) {
  AttitudeController controller;
  ModuleRig rig(controller);
  msg::AttitudeSetpoint wanted;
  wanted.thrust_n = math::kInf;
  wanted.armed = 1;
  rig.put("attitude", wanted);
  rig.put("state", good_state(0));
  EXPECT_EQ(rig.step({kMs}, 1ms), StepStatus::fault);
  wanted.thrust_n = 10;
  rig.put("attitude", wanted);
  msg::NavState state = good_state(kMs);
  state.gyro_radps.x = math::kNan;
  rig.put("state", state);
  EXPECT_EQ(rig.step({kMs}, 1ms), StepStatus::fault);
}

/// An attitude controller at 1 kHz with a vehicle of a given tilt.
struct Tilted {
  AttitudeController controller;
  ModuleRig rig{controller};
  std::int64_t ns = 0;
  StepStatus run(int ms, double tilt_rad, bool armed = true) {
    StepStatus last = StepStatus::stale;
    for (int i = 0; i < ms; ++i) {
      msg::AttitudeSetpoint wanted;
      wanted.stamp = {ns += kMs};
      wanted.thrust_n = 10;
      wanted.armed = armed;
      rig.put("attitude", wanted);
      msg::NavState state = good_state(ns);
      state.q_world_base = math::Quat::from_axis_angle({0, 1, 0}, tilt_rad).to<msg::Quat>();
      rig.put("state", state);
      last = rig.step({ns}, 1ms);
    }
    return last;
  }
};

TEST(AttitudeController, VehicleThatHasTippedOverGetsNothingUntilDisarmed) {
  Tilted t;
  EXPECT_EQ(t.run(500, 1.0), StepStatus::ok) << "a steep turn";
  EXPECT_EQ(t.run(90, 1.4), StepStatus::ok) << "not for long enough";
  EXPECT_EQ(t.run(20, 1.4), StepStatus::fault);
  EXPECT_EQ(t.rig.get<msg::WrenchSetpoint>("wrench"), nullptr);
  EXPECT_EQ(t.run(500, 0.0), StepStatus::fault) << "lying level again does not make it fly";
  EXPECT_EQ(t.run(1, 0.0, false), StepStatus::ok);
  EXPECT_EQ(t.run(10, 0.0), StepStatus::ok);
}

TEST(Mixer, DisarmedStopsAllMotorsAndArmedKeepsThemTurning) {
  Mixer mixer;
  ModuleRig rig(mixer);
  msg::WrenchSetpoint wrench;
  wrench.thrust_n = 12;
  rig.put("wrench", wrench);
  ASSERT_EQ(rig.step({kMs}, 1ms), StepStatus::ok);
  const auto* motors = rig.get<msg::ActuatorCommand>("motors");
  EXPECT_EQ(motors->count, 4u);
  EXPECT_EQ(motors->armed, 0u);
  EXPECT_THAT(motors->value, ::testing::Each(0.0));

  wrench.armed = 1;
  rig.put("wrench", wrench);
  ASSERT_EQ(rig.step({2 * kMs}, 1ms), StepStatus::ok);
  motors = rig.get<msg::ActuatorCommand>("motors");
  EXPECT_THAT(motors->value, ::testing::ElementsAre(0.5, 0.5, 0.5, 0.5, 0, 0, 0, 0));
}

TEST(Mixer, OldOrBrokenWrenchIsNotPassedOn) {
  Mixer mixer;
  ModuleRig rig(mixer);
  msg::WrenchSetpoint wrench;
  wrench.armed = 1;
  rig.put("wrench", wrench);
  EXPECT_EQ(rig.step({20 * kMs}, 1ms), StepStatus::stale);
  wrench.stamp = {21 * kMs};
  wrench.torque_nm.y = math::kNan;
  rig.put("wrench", wrench);
  EXPECT_EQ(rig.step({21 * kMs}, 1ms), StepStatus::fault);
  EXPECT_EQ(rig.get<msg::ActuatorCommand>("motors"), nullptr);
}

TEST(Mission, PublishesSetpointAndStateAndNothingWithoutAFreshEstimate) {
  Mission mission;
  ModuleRig rig(mission);
  EXPECT_EQ(rig.step({kMs}, 5ms), StepStatus::stale);
  rig.put("state", good_state(2 * kMs));
  ASSERT_EQ(rig.step({2 * kMs}, 5ms), StepStatus::ok);
  EXPECT_EQ(rig.get<msg::MissionState>("mission")->phase, msg::MissionPhase::wait);
  EXPECT_EQ(rig.get<msg::FlightSetpoint>("setpoint")->armed, 0u);
  EXPECT_EQ(rig.step({50 * kMs}, 5ms), StepStatus::stale);
  EXPECT_EQ(rig.get<msg::FlightSetpoint>("setpoint"), nullptr);
}

TEST(Mission, ParameterOutsideItsRangeIsRefusedInWords) {
  Mission mission;
  ModuleRig rig(mission);
  EXPECT_NE(rig.refusal("sink_slow_mps", -1.0), "");
  EXPECT_EQ(rig.refusal("sink_slow_mps", 0.3), "");
}

}  // namespace
}  // namespace sinew::control::modules_test
