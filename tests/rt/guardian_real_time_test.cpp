// The guardian on real threads: its reaction to a broken module, not its speed.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <limits>
#include <thread>

#include "graph_fixture.hpp"
#include "hal/platform.hpp"
#include "hal/wide.hpp"
#include "rt/exec/real_time_executor.hpp"
#include "rt/guardian.hpp"
#include "rt/latch.hpp"

namespace sinew::rt::guardian_real_time_test {
namespace {

using msg::FailsafeAction;

enum class How { good, disarmed, silent, failing, not_a_number, beyond, stuck_in_its_step };

class Commander final : public Module {
 public:
  void declare(Declaration& d) override { d.out("out", out_); }
  StepStatus step(const Step& step) noexcept override {
    const How h = how.load();
    while (how.load() == How::stuck_in_its_step) {
    }
    if (h == How::silent) return StepStatus::stale;
    if (h == How::failing) return StepStatus::fault;
    msg::ActuatorCommand& c = out_.loan();
    c.stamp = step.now;
    c.count = 2;
    c.armed = h != How::disarmed;
    c.value[0] = c.value[1] = h == How::not_a_number ? std::numeric_limits<double>::quiet_NaN()
                              : h == How::beyond     ? 2
                                                     : 0.5;
    return StepStatus::ok;
  }
  std::atomic<How> how{How::good};

 private:
  Out<msg::ActuatorCommand> out_;
};

class Sensor final : public Module {
 public:
  void declare(Declaration& d) override { d.out("raw", out_); }
  StepStatus step(const Step& step) noexcept override {
    if (silent.load()) return StepStatus::stale;
    msg::BatterySample& s = out_.loan();
    s.stamp = step.now;
    s.current_a = step.number;
    s.voltage_v = voltage_v.load();
    return StepStatus::ok;
  }
  std::atomic<bool> silent{false};
  hal::Wide<double> voltage_v{12};

 private:
  Out<msg::BatterySample> out_;
};

/// Told by the guardian's thread, read by the test's.
class SharedMotors final : public hal::Actuators {
 public:
  hal::Status write(const msg::ActuatorCommand& c, Duration lease) noexcept override {
    for (int i = 0; i < 2; ++i)
      if (!(c.value[i] >= -1 && c.value[i] <= 1)) wrong.fetch_add(1);
    if (lease <= Duration{0}) wrong.fetch_add(1);
    writes.fetch_add(1);
    moving.store(true);
    return {};
  }
  hal::Status stop() noexcept override {
    if (moving.exchange(false)) stops.fetch_add(1);
    return {};
  }
  std::atomic<bool> moving{false};
  std::atomic<int> wrong{0}, writes{0}, stops{0};
};

class MotorBoard final : public hal::EmptyBoard {
 public:
  hal::Result<hal::Actuators*> actuators(std::string_view) override { return &motors; }
  SharedMotors motors;
};

class GuardianInRealTime : public ::testing::Test {
 protected:
  GuardianInRealTime() {
    robot.virtual_time = false;
    robot.periodic("control", 10, 2ms, {"commander"});
    robot.periodic("sensing", 5, 10ms, {"sensor"});
    robot.two_motors(50ms);
  }
  ~GuardianInRealTime() override {
    commander.how = How::good;
    if (executor) executor->stop();
    EXPECT_EQ(board.motors.wrong.load(), 0) << "what reached the motors";
  }
  FailsafeSpec& condition(FailsafeSpec::Kind kind, Duration time, FailsafeAction action) {
    robot.spec.failsafes.emplace_back();
    FailsafeSpec& f = robot.spec.failsafes.back();
    f.name = "condition";
    f.topic = {"sensor.raw", 0};
    f.kind = kind;
    f.time = time;
    f.action = action;
    return f;
  }
  void start() {
    graph = std::make_unique<Graph>(robot.spec, robot.types);
    for (const Problem& p : graph->check()) ADD_FAILURE() << to_string(p, "test");
    ASSERT_TRUE(graph->configure(board, {.taps = {"guardian.state", "guardian.motors"}}));
    latch_ = std::make_unique<Latch>(graph->segment());
    latch_->bind(safety_, graph->taps()[0]);
    latch_->bind(group_, graph->taps()[1]);
    executor = std::make_unique<RealTimeExecutor>(*graph, hal::system_os());
    ASSERT_TRUE(executor->start());
  }
  /// False after a minute, which fails the test that asked.
  template <class Condition>
  bool until(Condition&& condition) {
    for (int i = 0; i < 60'000; ++i) {
      latch_->latch();
      if (const auto* s = safety_.get()) safety = *s;
      if (const auto* g = group_.get()) group = *g;
      latch_->release();
      if (condition()) return true;
      std::this_thread::sleep_for(1ms);
    }
    return false;
  }
  bool until_moving() {
    return until([this] { return board.motors.moving.load(); });
  }
  bool until_fault(std::uint32_t fault) {
    return until([this, fault] { return (group.faults & fault) && !board.motors.moving.load(); });
  }
  /// In what follows for a while, nothing goes out.
  bool stays_stopped() {
    const int writes = board.motors.writes.load();
    std::this_thread::sleep_for(100ms);
    return board.motors.writes.load() == writes;
  }

  Robot robot;
  MotorBoard board;
  Commander& commander = robot.add<Commander>("commander");
  Sensor& sensor = robot.add<Sensor>("sensor");
  std::unique_ptr<Graph> graph;
  std::unique_ptr<RealTimeExecutor> executor;
  msg::SafetyState safety;
  msg::GuardianState group;

 private:
  std::unique_ptr<Latch> latch_;
  In<msg::SafetyState> safety_;
  In<msg::GuardianState> group_;
};

struct Broken {
  How how;
  std::uint32_t fault;
  bool recovers;
};
class BrokenCommander : public GuardianInRealTime, public ::testing::WithParamInterface<Broken> {};

TEST_P(BrokenCommander, IsStoppedAndFollowedAgainWhenItIsWell) {
  start();
  ASSERT_TRUE(until_moving());
  commander.how = GetParam().how;
  ASSERT_TRUE(until_fault(GetParam().fault));
  EXPECT_TRUE(stays_stopped());
  commander.how = How::good;
  if (GetParam().recovers)
    EXPECT_TRUE(until_moving());
  else
    EXPECT_TRUE(stays_stopped()) << "a module that failed ten times in a row stays off";
}
INSTANTIATE_TEST_SUITE_P(Guardian, BrokenCommander,
                         ::testing::Values(Broken{How::silent, msg::kFaultLease, true},
                                           Broken{How::failing, msg::kFaultLease, false},
                                           Broken{How::not_a_number, msg::kFaultNotFinite, true},
                                           Broken{How::beyond, msg::kFaultLimit, true},
                                           Broken{How::stuck_in_its_step, msg::kFaultLease, true}));

TEST_F(GuardianInRealTime, ADisabledCommanderIsStopped) {
  start();
  ASSERT_TRUE(until_moving());
  ASSERT_TRUE(graph->set_enabled("commander", false));
  ASSERT_TRUE(until_fault(msg::kFaultLease));
  EXPECT_TRUE(stays_stopped());
}

TEST_F(GuardianInRealTime, TheEndOfTheRunDoesNotWaitForTheLease) {
  robot.spec.actuators[0].lease = 10s;
  start();
  ASSERT_TRUE(until_moving());
  executor->stop();
  EXPECT_FALSE(board.motors.moving.load());
  EXPECT_EQ(board.motors.stops.load(), 1);
}

TEST_F(GuardianInRealTime, ASilentSensorAsksForALanding) {
  condition(FailsafeSpec::Kind::silent, 2s, FailsafeAction::land);
  start();
  ASSERT_TRUE(until_moving());
  sensor.silent = true;
  ASSERT_TRUE(until([this] { return safety.action == FailsafeAction::land; }));
  EXPECT_TRUE(until_moving()) << "there must be something to land with";
  sensor.silent = false;
  ASSERT_TRUE(until([this] { return safety.conditions == 0; }));
  EXPECT_EQ(safety.action, FailsafeAction::land) << "it is latched";
}

TEST_F(GuardianInRealTime, ABadValueStopsForGood) {
  FailsafeSpec& f = condition(FailsafeSpec::Kind::value, 50ms, FailsafeAction::stop);
  f.field = {"voltage_v", 0};
  f.below = 10;
  start();
  ASSERT_TRUE(until_moving());
  sensor.voltage_v.store(9);
  ASSERT_TRUE(until_fault(msg::kFaultFailsafe));
  sensor.voltage_v.store(12);
  EXPECT_TRUE(stays_stopped());
}

TEST_F(GuardianInRealTime, NothingMovesBeforeItIsArmedByHand) {
  robot.spec.guardian.arming = GuardianSpec::Arming::manual;
  commander.how = How::disarmed;
  start();
  ASSERT_TRUE(until([this] { return safety.ready != 0; }));
  EXPECT_TRUE(stays_stopped());
  // Again when it was refused: a machine that stalls makes the commander late, and for a moment it is not ready.
  hal::Result<Ticket> armed = graph->arm();
  ASSERT_TRUE(until([&] {
    const auto effect = armed ? graph->effect(*armed) : std::nullopt;
    if (!armed || (effect && effect->refused)) armed = graph->arm();
    return safety.permitted != 0;
  }));
  commander.how = How::good;
  EXPECT_TRUE(until_moving());
  ASSERT_TRUE(graph->disarm());
  ASSERT_TRUE(until([this] { return safety.permitted == 0 && !board.motors.moving.load(); }));
  EXPECT_TRUE(stays_stopped());
}

}  // namespace
}  // namespace sinew::rt::guardian_real_time_test
