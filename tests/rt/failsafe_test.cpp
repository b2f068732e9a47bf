// Arming and failsafe conditions in virtual time: who may move, from when on, and until when.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "graph_fixture.hpp"
#include "rt/guardian.hpp"
#include "rt/safety_text.hpp"

namespace sinew::rt::failsafe_test {
namespace {

using msg::FailsafeAction;
using msg::GuardianMode;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using Kind = FailsafeSpec::Kind;

/// Commands what the test wants; gives up when it is not permitted, if it is that kind of controller.
class Commander final : public Module {
 public:
  void declare(Declaration& d) override {
    d.in("safety", safety_, {.optional = true, .supervises = true});
    d.out("out", out_);
  }
  StepStatus step(const Step& step) noexcept override {
    if (silent) return StepStatus::stale;
    const msg::SafetyState* s = safety_.get();
    if (s && s->permitted) was_permitted_ = true;
    const bool gives_up = obedient && s && !s->permitted && was_permitted_;
    if (gives_up) armed = 0;
    msg::ActuatorCommand& c = out_.loan();
    c.stamp = step.now;
    c.count = count;
    c.armed = armed;
    c.value[0] = c.value[1] = value;
    return StepStatus::ok;
  }
  bool silent = false, obedient = false;
  std::uint32_t count = 2, armed = 1;
  double value = 0.5;

 private:
  In<msg::SafetyState> safety_;
  Out<msg::ActuatorCommand> out_;
  bool was_permitted_ = false;
};

/// A sensor every 10 ms that can fall silent, get stuck or lie.
class Sensor final : public Module {
 public:
  void declare(Declaration& d) override { d.out("raw", out_); }
  StepStatus step(const Step& step) noexcept override {
    if (silent) return StepStatus::stale;
    if (!stuck) ++turn_;
    msg::BatterySample& s = out_.loan();
    s.stamp = step.now;
    s.voltage_v = voltage_v;
    s.current_a = turn_;
    return StepStatus::ok;
  }
  bool silent = false, stuck = false;
  double voltage_v = 12;

 private:
  Out<msg::BatterySample> out_;
  double turn_ = 0;
};

class SafetyLog final : public Module {
 public:
  SafetyLog() { states.reserve(50'000); }
  void declare(Declaration& d) override {
    d.in("in", in_, {.depth = 16});
    d.in("group", group_);
  }
  StepStatus step(const Step&) noexcept override {
    for (const auto& s : in_) states.push_back(s);
    if (const msg::GuardianState* g = group_.get()) last_group = *g;
    return StepStatus::ok;
  }
  std::vector<msg::SafetyState> states;
  msg::GuardianState last_group;

 private:
  InQueue<msg::SafetyState> in_;
  In<msg::GuardianState> group_;
};

/// A commander at 1 kHz (commits 10 us after its release), a sensor every 10 ms (commits 10 us after x.5 ms), a
/// guardian that takes 5 us.
class FailsafeTest : public ::testing::Test {
 protected:
  FailsafeTest() : motors(robot.board.add("motors", robot.clock)) {
    robot.periodic("control", 10, 1ms, {"commander"});
    robot.periodic("sensing", 20, 10ms, {"sensor"}).phase = 500us;
    robot.on_topics("log", 5, {"guardian.state"}, {"log"});
    robot.two_motors(5ms);
  }
  FailsafeSpec& condition(Kind kind, Duration time, FailsafeAction action) {
    robot.spec.failsafes.emplace_back();
    FailsafeSpec& f = robot.spec.failsafes.back();
    f.name = "condition" + std::to_string(robot.spec.failsafes.size());
    f.topic = {"sensor.raw", 0};
    f.kind = kind;
    f.time = time;
    f.action = action;
    return f;
  }
  FailsafeSpec& voltage_below(double v, Duration time, FailsafeAction action) {
    FailsafeSpec& f = condition(Kind::value, time, action);
    f.field = {"voltage_v", 0};
    f.below = v;
    return f;
  }
  void manual() { robot.spec.guardian.arming = GuardianSpec::Arming::manual; }
  void at(Duration t, std::function<void()> action) { robot.grants.at(Time{t.count()}, std::move(action)); }
  Guardian& guardian() { return *robot.graph().modules()[0].guardian; }
  /// The state as of the instant t.
  const msg::SafetyState& state_at(Duration t) const {
    const msg::SafetyState* found = &log.states.front();
    for (const auto& s : log.states)
      if (s.stamp.ns <= t.count()) found = &s;
    return *found;
  }
  bool moved_between(Duration from, Duration to) const {
    for (const auto& e : motors.events)
      if (!e.stopped && e.value[0] != 0 && e.at.ns >= from.count() && e.at.ns < to.count()) return true;
    return false;
  }
  Time first_stop_since(Duration t) const {
    for (const auto& e : motors.events)
      if (e.stopped && e.at.ns >= t.count()) return e.at;
    return Time{INT64_MAX};
  }
  Time first_action(FailsafeAction action) const {
    for (const auto& s : log.states)
      if (s.action == action) return s.stamp;
    return Time{INT64_MAX};
  }
  std::vector<std::string> reasons_at(Duration t) const { return not_ready(robot.spec, state_at(t)); }

  Robot robot;
  FakeActuators& motors;
  Commander& commander = robot.add<Commander>("commander", {{"safety", "guardian.state"}});
  Sensor& sensor = robot.add<Sensor>("sensor");
  SafetyLog& log = robot.add<SafetyLog>("log", {{"in", "guardian.state"}, {"group", "guardian.motors"}});
};

// ---- reports

TEST_F(FailsafeTest, AGroupThatHoldsOrGetsSetpointsMovesWhateverTheOthersDo) {
  Commander& second = robot.add<Commander>("second");
  robot.periodic("gripping", 10, 1ms, {"second"});
  robot.board.add("gripper", robot.clock);
  ActuatorSpec gripper = robot.spec.actuators[0];
  gripper.name = "gripper";
  gripper.command = {"second.out", 0};
  gripper.safe = ActuatorSpec::Safe::hold;
  robot.spec.actuators.push_back(gripper);
  at(20ms, [&] { commander.silent = true; });
  at(40ms, [&] { second.silent = true; });
  at(60ms, [&] { second.silent = false, second.value = 0; });
  robot.run(80ms);
  EXPECT_EQ(state_at(19ms).groups_moving, 0b11u);
  EXPECT_EQ(state_at(39ms).mode, GuardianMode::safe);
  EXPECT_EQ(state_at(39ms).groups_moving, 0b10u);
  EXPECT_EQ(state_at(59ms).groups_moving, 0b10u) << "it holds";
  EXPECT_EQ(state_at(79ms).groups_moving, 0u);
}

// ---- arming

TEST_F(FailsafeTest, ManualArmingLetsNothingPassBeforeItIsAskedFor) {
  manual();
  commander.value = 0;
  bool armed = false;
  at(20'500us, [&] { armed = guardian().arm(); });
  at(30'500us, [&] { commander.value = 0.5; });
  robot.run(50ms);
  EXPECT_TRUE(armed);
  EXPECT_EQ(state_at(20ms).permitted, 0u);
  EXPECT_EQ(state_at(20ms).ready, 1u);
  EXPECT_EQ(state_at(20ms).mode, GuardianMode::standby);
  EXPECT_EQ(state_at(30ms).mode, GuardianMode::armed);
  EXPECT_FALSE(moved_between(0ms, 31ms));
  EXPECT_TRUE(moved_between(31ms, 32ms));
  EXPECT_LT(first_stop_since(0ms), Time{1'000'000});
}

TEST_F(FailsafeTest, ArmingWithThrottleUpIsRefused) {
  manual();
  bool armed = true;
  at(20'500us, [&] { armed = guardian().arm(); });
  robot.run(50ms);
  EXPECT_FALSE(armed);
  EXPECT_FALSE(moved_between(0ms, 50ms));
  EXPECT_THAT(reasons_at(20ms), ElementsAre("motors: the command on commander.out is not idle"));
}

TEST_F(FailsafeTest, ArmingWithoutAFreshCommandIsRefused) {
  manual();
  commander.value = 0;
  bool armed = true;
  at(10'500us, [&] { commander.silent = true; });
  at(30'500us, [&] { armed = guardian().arm(); });
  robot.run(50ms);
  EXPECT_FALSE(armed);
  EXPECT_THAT(reasons_at(10ms), IsEmpty());
  EXPECT_THAT(reasons_at(30ms), ElementsAre("motors: no fresh command on commander.out"));
}

TEST_F(FailsafeTest, AllReasonsComeAtOnce) {
  manual();
  condition(Kind::silent, 50ms, FailsafeAction::land).name = "sensor_lost";
  voltage_below(10, 0ms, FailsafeAction::land).name = "battery_low";
  robot.spec.failsafes.back().above = 14;
  condition(Kind::stuck, 20ms, FailsafeAction::stop).name = "sensor_stuck";
  commander.count = 3;
  motors.refuses = true;
  sensor.voltage_v = 9.5;
  sensor.stuck = true;
  at(45ms, [&] { sensor.silent = true; });
  robot.run(120ms);
  EXPECT_THAT(reasons_at(100ms),
              ElementsAre("sensor_lost: sensor.raw has been silent for 58 ms (at most 50 ms)",
                          "battery_low: sensor.raw.voltage_v is 9.5 (at least 10, at most 14)",
                          "sensor_stuck: sensor.raw has not changed for 40 ms (at most 20 ms)",
                          "motors: the command on commander.out has 3 channels; actuator.motors.channels is 2",
                          "motors: the command on commander.out is not idle", "motors: the device refuses commands"));
}

TEST_F(FailsafeTest, OneReasonIsToldOfACommandThatMayNotPassWithBothNumbers) {
  manual();
  at(20ms, [&] { commander.value = 1.5; });
  at(40ms, [&] { commander.value = std::nan(""); });
  at(60ms, [&] { commander.count = 1; });
  robot.run(80ms);
  const std::string command = "the command on commander.out ";
  const auto first = [&](Duration t) { return reasons_at(t).empty() ? std::string("none") : reasons_at(t)[0]; };
  EXPECT_EQ(first(15ms), "motors: " + command + "is not idle");
  EXPECT_EQ(first(35ms), "motors: channel 0 of " + command + "is 1.5; actuator.motors.limit is [-1, 1]");
  EXPECT_EQ(first(55ms), "motors: channel 0 of " + command + "is not finite");
  EXPECT_EQ(first(75ms), "motors: " + command + "has 1 channels; actuator.motors.channels is 2");
}

TEST_F(FailsafeTest, ASecondBadCommandIsNamedBesideTheReasonOfTheFirst) {
  manual();
  robot.add<Commander>("second").value = 7;
  robot.periodic("gripping", 10, 1ms, {"second"});
  robot.board.add("gripper", robot.clock);
  ActuatorSpec gripper = robot.spec.actuators[0];
  gripper.name = "gripper";
  gripper.command = {"second.out", 0};
  robot.spec.actuators.push_back(gripper);
  commander.count = 3, commander.armed = 0;
  robot.run(20ms);
  EXPECT_THAT(reasons_at(15ms), ElementsAre("motors: the command on commander.out has 3 channels; "
                                            "actuator.motors.channels is 2",
                                            "gripper: the command on second.out may not pass either",
                                            "gripper: the command on second.out is not idle"));
}

TEST_F(FailsafeTest, ASensorThatHasNeverSaidAnythingIsNotReady) {
  condition(Kind::silent, 500ms, FailsafeAction::land).name = "sensor_lost";
  voltage_below(10, 1s, FailsafeAction::land).name = "battery_low";
  sensor.silent = true;
  robot.run(50ms);
  EXPECT_FALSE(moved_between(0ms, 50ms));
  EXPECT_THAT(reasons_at(20ms), ElementsAre("sensor_lost: nothing has come on sensor.raw",
                                            "battery_low: sensor.raw.voltage_v is no number (at least 10)"));
}

TEST_F(FailsafeTest, AutomaticArmingWaitsUntilEverythingIsReady) {
  condition(Kind::silent, 50ms, FailsafeAction::land);
  sensor.silent = true;
  at(30ms, [&] { sensor.silent = false; });
  robot.run(50ms);
  EXPECT_FALSE(moved_between(0ms, 31ms));
  EXPECT_TRUE(moved_between(31ms, 32ms)) << "the sensor's first message came at 30.51 ms";
}

TEST_F(FailsafeTest, DisarmingInFlightStopsAndStaysStopped) {
  at(10'500us, [&] { guardian().disarm(); });
  robot.run(50ms);
  EXPECT_TRUE(moved_between(9ms, 10'500us));
  EXPECT_LE(first_stop_since(10'500us), Time{11'020'000});
  EXPECT_FALSE(moved_between(11'020us, 50ms)) << "with automatic arming, too";
  EXPECT_EQ(log.states.back().mode, GuardianMode::standby);
  EXPECT_EQ(state_at(10ms).disarmed, Time{});
  EXPECT_EQ(log.states.back().disarmed, first_stop_since(10'500us) - 5us) << "and says so to the end";
}

TEST_F(FailsafeTest, DisarmingWhatIsNotLiveIsNotRemembered) {
  commander.armed = 0;
  at(10'500us, [&] { guardian().disarm(); });
  at(20'500us, [&] { guardian().arm(); });
  robot.run(50ms);
  EXPECT_EQ(log.states.back().disarmed, Time{});
}

TEST_F(FailsafeTest, AfterDisarmingByHandOnlyArmingByHandHelps) {
  std::vector<bool> answers;
  at(10'500us, [&] { guardian().disarm(); });
  at(20'500us, [&] { answers.push_back(guardian().arm()); });
  at(25'500us, [&] { commander.value = 0; });
  at(30'500us, [&] { answers.push_back(guardian().arm()); });
  at(35'500us, [&] { commander.value = 0.5; });
  robot.run(50ms);
  EXPECT_THAT(answers, ElementsAre(false, true));
  EXPECT_FALSE(moved_between(11'020us, 36ms));
  EXPECT_TRUE(moved_between(36ms, 50ms));
}

TEST_F(FailsafeTest, TheControllersOwnDisarmingEndsAManualPermission) {
  manual();
  commander.value = 0;
  at(10'500us, [&] { EXPECT_TRUE(guardian().arm()); });
  at(20'500us, [&] { commander.armed = 0; });
  at(30'500us, [&] { commander.armed = 1, commander.value = 0.5; });
  robot.run(50ms);
  EXPECT_EQ(state_at(20ms).permitted, 1u);
  EXPECT_EQ(state_at(30ms).permitted, 0u);
  EXPECT_FALSE(moved_between(0ms, 50ms)) << "it may not start again on the old permission";
}

TEST_F(FailsafeTest, AConditionOnTheGroundEndsThePermissionAndActsOnNothing) {
  manual();
  condition(Kind::silent, 30ms, FailsafeAction::land);
  commander.armed = 0;
  at(20'500us, [&] { EXPECT_TRUE(guardian().arm()); });
  at(25ms, [&] { sensor.silent = true; });
  at(70ms, [&] { sensor.silent = false; });
  robot.run(100ms);
  EXPECT_EQ(state_at(50ms).permitted, 1u);
  EXPECT_EQ(state_at(60ms).permitted, 0u);
  EXPECT_EQ(log.states.back().permitted, 0u) << "nor is it given again by itself";
  EXPECT_EQ(log.states.back().ready, 1u);
  EXPECT_EQ(log.states.back().acted, 0u);
}

TEST_F(FailsafeTest, WhatWasNeverPermittedIsNotHeld) {
  manual();
  robot.spec.actuators[0].safe = ActuatorSpec::Safe::hold;
  at(10'500us, [&] { commander.value = std::numeric_limits<double>::quiet_NaN(); });
  robot.run(30ms);
  EXPECT_FALSE(moved_between(0ms, 30ms));
}

TEST_F(FailsafeTest, WhoHasNoPermissionIsSwitchedOffWhateverElseIsWrong) {
  manual();
  commander.value = 0;
  at(10'500us, [&] { EXPECT_TRUE(guardian().arm()); });
  at(20'500us, [&] { commander.silent = true; });
  at(40'500us, [&] { guardian().disarm(); });
  robot.run(60ms);
  for (const auto& e : motors.events) {
    if (!e.stopped) continue;
    const bool permitted = e.at > Time{10'500'000} && e.at < Time{40'500'000};
    EXPECT_EQ(e.fell_back.has_value(), permitted)
        << "a lease that is over is the device's to end; a kill is not: " << e.at.ns;
  }
  EXPECT_TRUE(motors.events.back().stopped);
}

TEST_F(FailsafeTest, AFailsafesStopSwitchesOffWhateverElseIsWrong) {
  robot.spec.actuators[0].safe = ActuatorSpec::Safe::damp;
  condition(Kind::silent, 50ms, FailsafeAction::stop);
  at(45ms, [&] { sensor.silent = true; });
  at(60ms, [&] { commander.value = std::numeric_limits<double>::quiet_NaN(); });
  robot.run(150ms);
  int fell = 0, off = 0;
  for (const auto& e : motors.events) {
    if (e.stopped && e.at < Time{91'010'000}) fell += e.fell_back == hal::FallBack::own;
    if (e.at < Time{91'010'000}) continue;
    EXPECT_TRUE(e.stopped && !e.fell_back) << e.at.ns;
    ++off;
  }
  EXPECT_GT(fell, 20);
  EXPECT_GT(off, 20);
}

// ---- conditions: when they act

TEST_F(FailsafeTest, SilenceActsWithTheFirstCommandAtOrAfterItsInstant) {
  condition(Kind::silent, 50ms, FailsafeAction::stop);
  at(45ms, [&] { sensor.silent = true; });  // the last message was committed at 40.51 ms
  robot.run(150ms);
  EXPECT_EQ(first_action(FailsafeAction::stop), Time{91'010'000}) << "due at 90.51 ms";
  EXPECT_EQ(first_stop_since(41ms), Time{91'015'000}) << "and 5 us for the guardian itself";
  EXPECT_EQ(log.last_group.faults & msg::kFaultFailsafe, msg::kFaultFailsafe);
  EXPECT_EQ(log.last_group.mode, GuardianMode::safe);
}

TEST_F(FailsafeTest, WithoutCommandsAConditionActsWithinTheCheckInterval) {
  robot.spec.actuators[0].safe = ActuatorSpec::Safe::hold;
  condition(Kind::silent, 50ms, FailsafeAction::stop);
  at(45ms, [&] { sensor.silent = commander.silent = true; });
  robot.run(150ms);
  const Time due{90'510'000}, acted = first_action(FailsafeAction::stop);
  EXPECT_GE(acted, due);
  EXPECT_LE(acted, due + Guardian::check_interval(robot.spec.actuators));
}

TEST_F(FailsafeTest, AStuckSensorActsWithTheMessageThatShowsIt) {
  condition(Kind::stuck, 20ms, FailsafeAction::stop);
  at(45ms, [&] { sensor.stuck = true; });  // the last other message was committed at 40.51 ms
  robot.run(150ms);
  EXPECT_EQ(first_action(FailsafeAction::stop), Time{61'010'000}) << "the message at 60.51 ms is the second equal one";
}

TEST_F(FailsafeTest, ASilentSensorIsNotStuck) {
  condition(Kind::stuck, 20ms, FailsafeAction::stop);
  at(45ms, [&] { sensor.silent = true; });
  robot.run(150ms);
  EXPECT_EQ(log.states.back().acted, 0u);
}

TEST_F(FailsafeTest, AValueActsOnlyAfterItHasBeenBadForItsTime) {
  voltage_below(10, 30ms, FailsafeAction::stop);
  at(45ms, [&] { sensor.voltage_v = 9.99; });
  at(65ms, [&] { sensor.voltage_v = 10; });    // two bad messages: 50.51 and 60.51 ms
  at(85ms, [&] { sensor.voltage_v = 9.99; });  // from 90.51 ms on
  robot.run(200ms);
  EXPECT_EQ(first_action(FailsafeAction::stop), Time{121'010'000}) << "due at 120.51 ms";
}

TEST_F(FailsafeTest, AValueThatIsNoNumberIsBad) {
  voltage_below(-1e9, 0ms, FailsafeAction::stop);
  at(45ms, [&] { sensor.voltage_v = std::numeric_limits<double>::quiet_NaN(); });
  robot.run(100ms);
  EXPECT_EQ(first_action(FailsafeAction::stop), Time{51'010'000});
}

TEST_F(FailsafeTest, AboveIsALimitToo) {
  FailsafeSpec& f = condition(Kind::value, 0ms, FailsafeAction::stop);
  f.field = {"voltage_v", 0};
  f.above = 12;
  at(45ms, [&] { sensor.voltage_v = 12.01; });
  robot.run(100ms);
  EXPECT_EQ(first_action(FailsafeAction::stop), Time{51'010'000}) << "12 itself is allowed";
}

/// Two joints of a group of three channels; what is behind `count` is never looked at.
class Joints final : public Module {
 public:
  void declare(Declaration& d) override { d.out("raw", out_); }
  StepStatus step(const Step& step) noexcept override {
    msg::JointState& s = out_.loan();
    s = {};
    s.stamp = step.now;
    s.temperature_c = {warm_c[0], warm_c[1], 500};
    s.count = count;
    return StepStatus::ok;
  }
  std::array<double, 2> warm_c{40, 41};
  std::uint32_t count = 2;

 private:
  Out<msg::JointState> out_;
};

class ListFailsafeTest : public FailsafeTest {
 protected:
  ListFailsafeTest() {
    robot.periodic("joints", 15, 10ms, {"joints"}).phase = 500us;
    FailsafeSpec& f = condition(Kind::value, 0ms, FailsafeAction::stop);
    f.topic = {"joints.raw", 0};
    f.field = {"temperature_c[*]", 0};
    f.above = 70;
  }
  Joints& joints = robot.add<Joints>("joints");
};

TEST_F(ListFailsafeTest, EachNumberInUseIsHeldToTheLimit) {
  at(45ms, [&] { joints.warm_c[1] = 71; });
  robot.run(100ms);
  EXPECT_EQ(first_action(FailsafeAction::stop), Time{51'010'000});
  EXPECT_EQ(log.states.back().measured[0], 71);
}

TEST_F(ListFailsafeTest, ANumberThatIsNotMeasuredIsLeftOut) {
  at(45ms, [&] { joints.warm_c[0] = std::numeric_limits<double>::quiet_NaN(); });
  robot.run(100ms);
  EXPECT_EQ(first_action(FailsafeAction::stop), Time{INT64_MAX});
  EXPECT_EQ(log.states.back().measured[0], 41);
}

TEST_F(ListFailsafeTest, AListWithoutAnyMeasurementIsBad) {
  at(45ms, [&] { joints.warm_c.fill(std::numeric_limits<double>::quiet_NaN()); });
  robot.run(100ms);
  EXPECT_EQ(first_action(FailsafeAction::stop), Time{51'010'000});
}

TEST_F(ListFailsafeTest, AnEmptyListIsBad) {
  at(45ms, [&] { joints.count = 0; });
  robot.run(100ms);
  EXPECT_EQ(first_action(FailsafeAction::stop), Time{51'010'000});
}

// ---- actions

TEST_F(FailsafeTest, LandLeavesThePermissionAndIsLatched) {
  condition(Kind::silent, 50ms, FailsafeAction::land);
  at(45ms, [&] { sensor.silent = true; });
  at(105ms, [&] { sensor.silent = false; });
  robot.run(150ms);
  EXPECT_EQ(first_stop_since(1ms), Time{INT64_MAX});
  EXPECT_EQ(state_at(100ms).conditions, 1u);
  const msg::SafetyState& end = log.states.back();
  EXPECT_EQ(end.conditions, 0u) << "it has vanished";
  EXPECT_EQ(end.latched, 1u);
  EXPECT_EQ(end.action, FailsafeAction::land);
  EXPECT_EQ(end.permitted, 1u) << "so that there is something to land with";
}

TEST_F(FailsafeTest, ALandingThatTakesTooLongIsStopped) {
  condition(Kind::silent, 50ms, FailsafeAction::land).stop_after = 40ms;
  at(45ms, [&] { sensor.silent = true; });
  at(105ms, [&] { sensor.silent = false; });
  robot.run(200ms);
  EXPECT_EQ(first_action(FailsafeAction::land), Time{91'010'000});
  EXPECT_EQ(first_action(FailsafeAction::stop), Time{131'010'000}) << "although the condition has vanished";
  EXPECT_FALSE(moved_between(131'020us, 200ms));
}

TEST_F(FailsafeTest, AStopIsLatchedWhileTheControllerWantsToGoOn) {
  condition(Kind::silent, 50ms, FailsafeAction::stop);
  at(45ms, [&] { sensor.silent = true; });
  at(105ms, [&] { sensor.silent = false; });
  robot.run(200ms);
  EXPECT_FALSE(moved_between(91'020us, 200ms));
  EXPECT_EQ(log.states.back().conditions, 0u);
  EXPECT_EQ(log.states.back().latched, 1u);
  EXPECT_THAT(reasons_at(200ms),
              ElementsAre("condition1: has acted; disarm first", "motors: the command on commander.out is not idle"));
}

TEST_F(FailsafeTest, WithAutomaticArmingTheControllersDisarmingForgetsAStop) {
  condition(Kind::silent, 50ms, FailsafeAction::stop);
  commander.obedient = true;
  at(45ms, [&] { sensor.silent = true; });
  at(105ms, [&] { sensor.silent = false; });
  at(150'500us, [&] { commander.obedient = false, commander.armed = 1; });
  robot.run(200ms);
  EXPECT_FALSE(moved_between(91'020us, 150ms));
  EXPECT_EQ(state_at(100ms).latched, 0u);
  EXPECT_EQ(state_at(100ms).permitted, 0u) << "the condition still holds";
  EXPECT_TRUE(moved_between(151ms, 152ms));
  EXPECT_EQ(log.states.back().acted, 1u) << "and what has been is not forgotten";
}

TEST_F(FailsafeTest, WithManualArmingAStopNeedsDisarmingAndArming) {
  manual();
  condition(Kind::silent, 50ms, FailsafeAction::stop);
  commander.value = 0;
  commander.obedient = true;
  std::vector<bool> answers;
  at(20'500us, [&] { answers.push_back(guardian().arm()); });
  at(45ms, [&] { sensor.silent = true; });
  at(105ms, [&] { sensor.silent = false; });
  at(150'500us, [&] { answers.push_back(guardian().arm()); });
  at(155'500us, [&] { guardian().disarm(); });
  at(160'500us, [&] { answers.push_back(guardian().arm()); });
  robot.run(200ms);
  EXPECT_THAT(answers, ElementsAre(true, false, true));
  EXPECT_EQ(log.states.back().disarmed, Time{}) << "it was stopped already";
}

TEST_F(FailsafeTest, TheWorseActionWins) {
  condition(Kind::silent, 50ms, FailsafeAction::stop);
  voltage_below(10, 0ms, FailsafeAction::land);
  at(35ms, [&] { sensor.voltage_v = 9; });
  at(45ms, [&] { sensor.silent = true; });
  robot.run(150ms);
  EXPECT_EQ(first_action(FailsafeAction::land), Time{41'010'000});
  EXPECT_EQ(first_action(FailsafeAction::stop), Time{91'010'000});
  EXPECT_EQ(log.states.back().latched, 3u);
}

// ---- fields

TEST(NumberFields, AreFoundByTheirPath) {
  msg::ImuSample imu;
  imu.gyro_radps.y = 2.5;
  const auto y = find_number(msg::type_info<msg::ImuSample>(), "gyro_radps.y");
  ASSERT_TRUE(y);
  EXPECT_EQ(y->read(&imu), 2.5);
  msg::ActuatorCommand command;
  command.value[7] = -3;
  command.count = 0xFFFFFFFF;
  const auto value = find_number(msg::type_info<msg::ActuatorCommand>(), "value[7]");
  const auto count = find_number(msg::type_info<msg::ActuatorCommand>(), "count");
  ASSERT_TRUE(value && count);
  EXPECT_EQ(value->read(&command), -3);
  EXPECT_EQ(count->read(&command), 4294967295.0);
}

TEST(NumberFields, WhatIsNoneIsNotFound) {
  const msg::TypeInfo& imu = msg::type_info<msg::ImuSample>();
  const msg::TypeInfo& command = msg::type_info<msg::ActuatorCommand>();
  for (const char* path :
       {"", "gyro_radps", "gyro_radps.", "gyro_radps.w", "gyro_radps.y.z", "stamp.x", "gyro_radps[0]"})
    EXPECT_FALSE(find_number(imu, path)) << path;
  for (const char* path : {"value", "value[8]", "value[-1]", "value[", "value[]", "value[1", "value[1]x", "count[0]"})
    EXPECT_FALSE(find_number(command, path)) << path;
}

TEST(NumberFields, AListIsAllOfAnArrayOrAsManyAsTheMessageCounts) {
  msg::ActuatorCommand command;
  command.count = 2;
  command.value = {1, 2, 3};
  const auto used = find_numbers(msg::type_info<msg::ActuatorCommand>(), "value[*]");
  ASSERT_TRUE(used);
  EXPECT_EQ(used->size(&command), 2u);
  EXPECT_EQ(used->read(&command, 1), 2);
  command.count = 0xFFFFFFFF;
  EXPECT_EQ(used->size(&command), msg::kMaxChannels);
  msg::SolePressure soles;
  soles.force_n = {4, 5};
  const auto all = find_numbers(msg::type_info<msg::SolePressure>(), "force_n[*]");
  ASSERT_TRUE(all);
  EXPECT_EQ(all->size(&soles), msg::kSoleCells);
  EXPECT_EQ(all->read(&soles, 1), 5);
  for (const char* path : {"force_n[*].x", "stamp[*]", "[*]", "force_n[*", "force[*]"})
    EXPECT_FALSE(find_numbers(msg::type_info<msg::SolePressure>(), path)) << path;
}

TEST(NumberFields, EveryListedPathIsFound) {
  for (const msg::TypeInfo* type : {&msg::type_info<msg::ImuSample>(), &msg::type_info<msg::SafetyState>()})
    for (const std::string& path : number_paths(*type)) EXPECT_TRUE(find_number(*type, path)) << path;
}

TEST(SafetyText, CauseSaysWhatTheConditionSaw) {
  FailsafeSpec silent{.topic = {"camera.raw"}, .kind = Kind::silent, .time = std::chrono::milliseconds(500)};
  EXPECT_EQ(cause_text(silent, 0.51), "camera.raw silent for 500 ms");
  silent.kind = Kind::stuck;
  EXPECT_EQ(cause_text(silent, 0.51), "camera.raw unchanged for 500 ms");
  FailsafeSpec value{.topic = {"battery.raw"}, .kind = Kind::value, .field = {"voltage_v"}, .below = 13.2};
  EXPECT_EQ(cause_text(value, 12.9), "battery.raw.voltage_v is 12.9 (at least 13.2)");
}

}  // namespace
}  // namespace sinew::rt::failsafe_test
