// The guardian in virtual time: its commands, when they go out, and its reports.
#include "rt/guardian.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "graph_fixture.hpp"

namespace sinew::rt::guardian_test {
namespace {

using msg::GuardianMode;
using Safe = ActuatorSpec::Safe;
using Event = FakeActuators::Event;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

/// Commands what the test wants.
class Commander final : public Module {
 public:
  void declare(Declaration& d) override { d.out("out", out_); }
  StepStatus step(const Step& step) noexcept override {
    if (silent) return StepStatus::stale;
    msg::ActuatorCommand& c = out_.loan();
    c.stamp = step.now - 1ms;
    c.count = count;
    c.armed = armed;
    c.value[0] = value;
    c.value[1] = value;
    return StepStatus::ok;
  }
  bool silent = false;
  std::uint32_t count = 2, armed = 1;
  double value = 0.5;

 private:
  Out<msg::ActuatorCommand> out_;
};

class StateLog final : public Module {
 public:
  StateLog() { states.reserve(10'000); }
  void declare(Declaration& d) override { d.in("in", in_, {.depth = 16}); }
  StepStatus step(const Step&) noexcept override {
    for (const auto& s : in_) states.push_back(s);
    return StepStatus::ok;
  }
  std::vector<msg::GuardianState> states;

 private:
  InQueue<msg::GuardianState> in_;
};

/// A commander at 1 kHz (done 10 us after its release), a lease of 5 ms, a guardian that takes 5 us.
class GuardianTest : public ::testing::Test {
 protected:
  GuardianTest() : motors(robot.board.add("motors", robot.clock)) {
    robot.periodic("control", 10, 1ms, {"commander"});
    robot.on_topics("log", 5, {"guardian.motors"}, {"log"});
    robot.two_motors(5ms);
  }
  ActuatorSpec& actuator() { return robot.spec.actuators[0]; }
  void at(Duration t, std::function<void()> action) { robot.grants.at(Time{t.count()}, std::move(action)); }
  /// The first command at or after t.
  const Event& first_since(Duration t) const {
    for (const Event& e : motors.events)
      if (e.at.ns >= t.count()) return e;
    ADD_FAILURE() << "nothing went out";
    static const Event none{};
    return none;
  }
  const Event* first_stop_since(Duration t) const {
    for (const Event& e : motors.events)
      if (e.at.ns >= t.count() && e.stopped) return &e;
    return nullptr;
  }
  /// The state as of the instant t.
  const msg::GuardianState& state_at(Duration t) const {
    const msg::GuardianState* found = &log.states.front();
    for (const auto& s : log.states)
      if (s.stamp.ns <= t.count()) found = &s;
    return *found;
  }
  /// A run in which from 3.5 ms on something is wrong, and from 6.5 ms on not any more.
  void run_with_fault(std::function<void()> wrong, std::function<void()> right) {
    at(3500us, std::move(wrong));
    at(6500us, std::move(right));
    robot.run(10ms);
  }
  void expect_stopped_and_recovered(std::uint32_t fault) {
    EXPECT_FALSE(first_since(3ms).stopped);
    EXPECT_TRUE(first_since(4ms).stopped) << "with the first wrong command";
    EXPECT_EQ(first_since(4ms).at, Time{4'015'000});
    EXPECT_EQ(state_at(4500us).mode, GuardianMode::safe);
    EXPECT_EQ(state_at(4500us).faults, fault);
    EXPECT_EQ(state_at(4500us).value[0], 0.0) << "what really went out";
    EXPECT_TRUE(first_since(6ms).stopped);
    EXPECT_FALSE(first_since(7ms).stopped) << "good commands return";
    EXPECT_EQ(first_since(7ms).value[0], 0.5);
    EXPECT_EQ(state_at(9ms).mode, GuardianMode::active);
    EXPECT_EQ(state_at(9ms).faults, 0u);
    EXPECT_EQ(state_at(9ms).fault_events, 1u) << "one, though it lasted";
  }

  Robot robot;
  FakeActuators& motors;
  Commander& commander = robot.add<Commander>("commander");
  StateLog& log = robot.add<StateLog>("log", {{"in", "guardian.motors"}});
};

TEST_F(GuardianTest, AGoodCommandPassesWithWhatIsLeftOfItsLease) {
  robot.run(500us);
  ASSERT_FALSE(motors.events.empty());
  const Event& e = motors.events[0];
  EXPECT_EQ(e.at, Time{15'000}) << "10 us commander, 5 us guardian";
  EXPECT_FALSE(e.stopped);
  EXPECT_EQ(e.value[0], 0.5);
  EXPECT_EQ(e.lease, Duration{5ms - 5us}) << "counted from the commit of the command";
  ASSERT_FALSE(log.states.empty());
  EXPECT_EQ(log.states[0].mode, GuardianMode::active);
  EXPECT_EQ(log.states[0].value[1], 0.5);
  EXPECT_EQ(log.states[0].count, 2u);
  EXPECT_EQ(log.states[0].command_stamp, Time{-1'000'000});
}

TEST_F(GuardianTest, EachModeIsTold) {
  commander.armed = 0;
  at(1500us, [&] { commander.armed = 1, commander.value = 0; });
  at(2500us, [&] { commander.value = 0.25; });
  robot.run(4ms);
  EXPECT_EQ(state_at(1ms).mode, GuardianMode::standby);
  EXPECT_TRUE(first_since(0us).stopped);
  EXPECT_EQ(state_at(2400us).mode, GuardianMode::armed);
  EXPECT_FALSE(first_since(2ms).stopped);
  EXPECT_EQ(state_at(3400us).mode, GuardianMode::active);
}

TEST_F(GuardianTest, ASilentCommanderIsStoppedAtTheInstantAtWhichItsLeaseEnds) {
  at(3500us, [&] { commander.silent = true; });
  robot.run(20ms);
  // The last command was committed at 3.010 ms and released the guardian; time-outs follow at half leases from then.
  const Event* stop = first_stop_since(0us);
  ASSERT_NE(stop, nullptr);
  EXPECT_EQ(stop->at, Time{3'010'000 + 5'000'000 + 5'000}) << "the lease, and 5 us for the guardian itself";
  EXPECT_EQ(stop->fell_back, hal::FallBack::own) << "how it stops is the device's own; it is not switched off";
  EXPECT_EQ(state_at(8100us).faults, msg::kFaultLease);
  EXPECT_EQ(state_at(8100us).mode, GuardianMode::safe);
  EXPECT_EQ(state_at(8009us).mode, GuardianMode::active);
  for (const Event& e : motors.events)
    if (e.at > stop->at) {
      EXPECT_TRUE(e.stopped) << "and stays stopped";
      EXPECT_EQ(e.fell_back, hal::FallBack::own);
    }
}

TEST_F(GuardianTest, ALeaseNeverReachesBeyondTheEndOfItsCommands) {
  at(3500us, [&] { commander.silent = true; });
  robot.run(20ms);
  for (const Event& e : motors.events) {
    const Time end{std::min<std::int64_t>(3'010'000, e.at.ns / 1'000'000 * 1'000'000 + 10'000) + 5'000'000};
    if (!e.stopped) {
      EXPECT_LE(e.at + e.lease, end) << e.at.ns;
    }
  }
}

TEST_F(GuardianTest, AnOddLeaseIsNoticedWithinItsCheckInterval) {
  actuator().lease = 5ms + 1ns;
  at(3500us, [&] { commander.silent = true; });
  robot.run(20ms);
  const Event* stop = first_stop_since(0us);
  ASSERT_NE(stop, nullptr);
  EXPECT_GE(stop->at, Time{8'010'001});
  EXPECT_LE(stop->at, Time{8'010'001 + 2'500'000 + 5'000});
  for (const Event& e : motors.events)
    if (!e.stopped) {
      EXPECT_LE(e.at + e.lease, Time{8'010'001}) << "the device's own lease ends in time all the same";
    }
}

TEST_F(GuardianTest, ACommanderThatIsPreemptedTooLongIsStopped) {
  class Hog final : public Module {
   public:
    void declare(Declaration&) override {}
    StepStatus step(const Step&) noexcept override { return StepStatus::ok; }
  };
  robot.add<Hog>("hog");
  robot.module("hog").exec.constant = 7ms;
  robot.periodic("hog", 20, 100ms, {"hog"}).phase = 3500us;
  robot.run(20ms);
  EXPECT_EQ(first_stop_since(0us)->at, Time{8'015'000}) << "the guardian is more urgent than the hog";
  EXPECT_FALSE(first_since(11ms).stopped);
}

TEST_F(GuardianTest, ANumberThatIsNoneStops) {
  run_with_fault([&] { commander.value = kNan; }, [&] { commander.value = 0.5; });
  expect_stopped_and_recovered(msg::kFaultNotFinite);
}

TEST_F(GuardianTest, InfinityStops) {
  run_with_fault([&] { commander.value = -kInf; }, [&] { commander.value = 0.5; });
  expect_stopped_and_recovered(msg::kFaultNotFinite);
}

TEST_F(GuardianTest, AValueOutsideItsLimitsStopsAndIsNotClamped) {
  run_with_fault([&] { commander.value = 1.0 + 0x1p-52; }, [&] { commander.value = 0.5; });
  expect_stopped_and_recovered(msg::kFaultLimit);
}

TEST_F(GuardianTest, AChannelMayHaveLimitsOfItsOwn) {
  actuator().channel_limits = {{-1, 1}, {-1, 0.6}};
  run_with_fault([&] { commander.value = 0.7; }, [&] { commander.value = 0.5; });
  expect_stopped_and_recovered(msg::kFaultLimit);
}

TEST_F(GuardianTest, TheLimitsThemselvesPass) {
  commander.value = 1.0;
  at(3500us, [&] { commander.value = -1.0; });
  robot.run(6ms);
  EXPECT_EQ(first_stop_since(0us), nullptr);
  EXPECT_EQ(first_since(4ms).value[0], -1.0);
}

TEST_F(GuardianTest, AWrongNumberOfChannelsStops) {
  run_with_fault([&] { commander.count = 3; }, [&] { commander.count = 2; });
  expect_stopped_and_recovered(msg::kFaultCount);
}

TEST_F(GuardianTest, ACountBeyondTheMessageIsHarmless) {
  run_with_fault([&] { commander.count = 0xFFFFFFFF; }, [&] { commander.count = 2; });
  expect_stopped_and_recovered(msg::kFaultCount);
}

TEST_F(GuardianTest, AChangeFasterThanAllowedStops) {
  actuator().rate_per_s = 200;  // 0.2 in the millisecond between two commands
  run_with_fault([&] { commander.value = 0.75; }, [&] { commander.value = 0.5; });
  EXPECT_TRUE(first_since(4ms).stopped);
  EXPECT_EQ(state_at(4500us).faults, msg::kFaultRate);
  EXPECT_FALSE(first_since(5ms).stopped) << "0.25 in the two milliseconds since the last good command";
  EXPECT_EQ(first_since(5ms).value[0], 0.75);
}

TEST_F(GuardianTest, AChangeAsFastAsAllowedPasses) {
  actuator().rate_per_s = 251;
  run_with_fault([&] { commander.value = 0.75; }, [&] { commander.value = 0.5; });
  EXPECT_EQ(first_stop_since(0us), nullptr);
}

TEST_F(GuardianTest, DisarmingStopsAtOnceAndIsNoFault) {
  run_with_fault([&] { commander.armed = 0; }, [&] { commander.armed = 1; });
  EXPECT_EQ(first_since(4ms).at, Time{4'015'000});
  EXPECT_TRUE(first_since(4ms).stopped);
  EXPECT_FALSE(first_since(4ms).fell_back) << "switched off";
  EXPECT_EQ(state_at(4500us).mode, GuardianMode::standby);
  EXPECT_FALSE(first_since(7ms).stopped);
  EXPECT_EQ(log.states.back().fault_events, 0u);
}

TEST_F(GuardianTest, ADisarmedCommandIsCheckedForNothing) {
  commander.armed = 0;
  commander.value = kNan;
  commander.count = 77;
  robot.run(20ms);
  EXPECT_EQ(log.states.back().mode, GuardianMode::standby);
  EXPECT_EQ(log.states.back().faults, 0u);
}

TEST_F(GuardianTest, BeforeTheFirstCommandItStopsAndStandsBy) {
  commander.silent = true;
  robot.run(20ms);
  ASSERT_FALSE(motors.events.empty());
  EXPECT_EQ(motors.events[0].at, Time{2'505'000}) << "half a lease after the start";
  for (const Event& e : motors.events) EXPECT_TRUE(e.stopped && !e.fell_back);
  EXPECT_EQ(log.states.back().mode, GuardianMode::standby);
}

TEST_F(GuardianTest, ADeviceThatRefusesIsAFaultUntilItTakesCommandsAgain) {
  run_with_fault([&] { motors.refuses = true; }, [&] { motors.refuses = false; });
  EXPECT_EQ(state_at(4500us).mode, GuardianMode::active) << "it refuses after the state was written";
  EXPECT_EQ(state_at(5500us).mode, GuardianMode::safe);
  EXPECT_EQ(state_at(5500us).faults, msg::kFaultDevice);
  EXPECT_TRUE(first_since(5ms).stopped);
  EXPECT_EQ(state_at(9ms).mode, GuardianMode::active);
  EXPECT_EQ(first_since(9ms).value[0], 0.5);
}

TEST_F(GuardianTest, HoldRepeatsTheLastGoodCommand) {
  actuator().safe = Safe::hold;
  at(2500us, [&] { commander.value = 0.25; });
  run_with_fault([&] { commander.value = kNan; }, [&] { commander.silent = true; });
  EXPECT_EQ(first_stop_since(0us), nullptr);
  EXPECT_EQ(first_since(4ms).value[0], 0.25);
  EXPECT_EQ(first_since(4ms).lease, Duration{5ms});
  EXPECT_EQ(state_at(4500us).mode, GuardianMode::safe);
  EXPECT_EQ(state_at(4500us).value[0], 0.25) << "what really went out";
  EXPECT_EQ(motors.events.back().value[0], 0.25);
  EXPECT_GT(motors.events.back().at, Time{7'000'000}) << "and on, while nothing comes";
}

TEST_F(GuardianTest, HoldWithoutAGoodCommandStops) {
  actuator().safe = Safe::hold;
  commander.value = kNan;
  robot.run(5ms);
  for (const Event& e : motors.events) EXPECT_TRUE(e.stopped);
}

TEST_F(GuardianTest, WhatWasGoodBeforeDisarmingIsNotHeldAfterwards) {
  actuator().safe = Safe::hold;
  at(2500us, [&] { commander.armed = 0; });
  at(3500us, [&] { commander.armed = 1, commander.value = kNan; });
  robot.run(8ms);
  EXPECT_TRUE(first_since(4ms).stopped);
  EXPECT_EQ(state_at(4500us).value[0], 0.0);
}

class EverySafeStop : public GuardianTest, public ::testing::WithParamInterface<Safe> {};

TEST_P(EverySafeStop, StopsTheDevice) {
  actuator().safe = GetParam();
  run_with_fault([&] { commander.value = kNan; }, [&] { commander.value = 0.5; });
  expect_stopped_and_recovered(msg::kFaultNotFinite);
  EXPECT_EQ(first_since(4ms).fell_back, GetParam() == Safe::torque_off ? hal::FallBack::limp : hal::FallBack::own);
}
INSTANTIATE_TEST_SUITE_P(Guardian, EverySafeStop, ::testing::Values(Safe::stop, Safe::damp, Safe::torque_off));

TEST_F(GuardianTest, AFaultOfOneGroupLeavesTheOtherAlone) {
  FakeActuators& gimbal = robot.board.add("gimbal", robot.clock);
  robot.add<Commander>("other");
  robot.periodic("other", 9, 1ms, {"other"}).phase = 100us;
  robot.spec.actuators.push_back(actuator());
  robot.spec.actuators[1].name = "gimbal";
  robot.spec.actuators[1].command = {"other.out", 0};
  robot.spec.actuators[1].lease = 3ms;
  StateLog& other_log = robot.add<StateLog>("other_log", {{"in", "guardian.gimbal"}});
  robot.on_topics("other_log", 4, {"guardian.gimbal"}, {"other_log"});
  at(3500us, [&] { commander.silent = true; });
  robot.run(15ms);
  EXPECT_EQ(log.states.back().mode, GuardianMode::safe);
  EXPECT_EQ(other_log.states.back().mode, GuardianMode::active);
  ASSERT_FALSE(gimbal.events.empty());
  for (const Event& e : gimbal.events)
    if (e.at > Time{200'000}) {
      EXPECT_FALSE(e.stopped) << e.at.ns;
    }
  const Event* stop = first_stop_since(1ms);
  ASSERT_NE(stop, nullptr);
  EXPECT_GE(stop->at, Time{8'010'000 + 5'000});
  EXPECT_LE(stop->at, Time{9'115'000}) << "the other group's commands release the guardian too";
}

TEST_F(GuardianTest, AnAbsentDeviceIsNamedAtTheStart) {
  actuator().name = "wheels";
  robot.spec.threads.pop_back();
  robot.spec.modules.pop_back();
  Graph graph(robot.spec, robot.types);
  const auto configured = graph.configure(robot.board);
  ASSERT_FALSE(configured);
  EXPECT_EQ(configured.error().code, hal::Errc::not_found);
  ASSERT_FALSE(graph.configure_problems().empty());
  EXPECT_EQ(graph.configure_problems()[0].allowed, "actuators 'wheels' of the board: fake board");
}

}  // namespace
}  // namespace sinew::rt::guardian_test
