// The real-time executor on the kernel, without an assertion about how fast anything is.
#include "rt/exec/real_time_executor.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "graph_fixture.hpp"
#include "hal/wide.hpp"
#include "probe_os.hpp"
#include "rt/exec/trigger.hpp"
#include "test_modules.hpp"
#include "trap.hpp"
#include "until.hpp"

namespace sinew::rt::real_time_test {
namespace {

using ::testing::ElementsAre;

/// Records of each module, written by its thread, read while the executor stands still.
class ThreadRecords final : public RunObserver {
 public:
  ThreadRecords() {
    for (auto& r : of) r.reserve(100'000);
    skips.reserve(100'000);
  }
  void completed(const StepRecord& r) noexcept override {
    auto& records = of[r.module];
    if (records.size() == records.capacity()) return;
    records.push_back(r);
    const ThreadStats* stats = watched.load(std::memory_order_acquire);
    if (r.module == 0) skips.push_back(stats ? stats->skips.value() : 0);
    count[r.module].store(records.size(), std::memory_order_release);
  }
  std::array<std::vector<StepRecord>, 8> of;
  std::atomic<const ThreadStats*> watched{nullptr};
  std::vector<std::uint64_t> skips;  // of the watched thread, when a step of module 0 completed
  std::array<std::atomic<std::size_t>, 8> count{};
};

/// Spins in one of its steps until the test lets it go; knows how many releases its thread had skipped by then.
class Blocker final : public Module {
 public:
  explicit Blocker(std::uint32_t blocks_in) : blocks_in_(blocks_in) {}
  void declare(Declaration&) override {}
  StepStatus step(const Step& step) noexcept override {
    if (step.number == blocks_in_) {
      blocked.store(true, std::memory_order_release);
      while (!go.load(std::memory_order_acquire)) {
      }
    }
    return StepStatus::ok;
  }
  std::atomic<bool> blocked{false}, go{false};

 private:
  const std::uint32_t blocks_in_;
};

/// A device that has samples when the test says so.
class Bell final : public hal::Device {
 public:
  Time ready_at() const noexcept override { return samples.load() > 0 ? Time{0} : hal::kNever; }
  void set_wake(hal::Wake* w) noexcept override { wake = w; }
  void ring(int count = 1) {
    samples.fetch_add(count);
    wake->wake();
  }
  hal::Wake* wake = nullptr;
  std::atomic<int> samples{0};
};

class BellReader final : public DriverModule {
 public:
  explicit BellReader(bool blocks = false) { go = !blocks; }
  void declare(Declaration& d) override { d.raw("raw", raw_, {.burst = 2}); }
  void collect(Time now) noexcept override {
    while (bell.samples.load() > 0) {
      Pair* p = raw_.loan();
      if (!p) return;
      p->stamp = now;
      bell.samples.fetch_sub(1);
    }
  }
  StepStatus step(const Step&) noexcept override {
    read.fetch_add(static_cast<std::uint32_t>(raw_.size()));
    begun.fetch_add(1);
    while (!go.load()) {
    }
    return StepStatus::ok;
  }
  hal::Device* device() override { return &bell; }
  Bell bell;
  std::atomic<std::uint32_t> read{0}, begun{0};
  std::atomic<bool> go{true};

 private:
  Raw<Pair> raw_;
};

class RealTime : public ::testing::Test {
 protected:
  RealTime() { robot.virtual_time = false; }
  hal::Status try_to_start() {
    options.start_delay = 1ms;
    options.runner.observer = &records;
    executor = std::make_unique<RealTimeExecutor>(robot.build(), os, options);
    return executor->start();
  }
  void start() {
    const auto started = try_to_start();
    ASSERT_TRUE(started) << started.error().where;
  }
  bool steps_of(std::uint32_t module, std::size_t count) {
    return until([&] { return records.count[module].load(std::memory_order_acquire) >= count; });
  }
  const ThreadStats& stats(std::uint32_t thread = 0) { return executor->runner().thread_stats(thread); }
  /// Release k of a thread with this period since the start; fails when it is between two.
  std::int64_t index_of(Time release, Duration period) {
    EXPECT_EQ((release - executor->started_at()) % period, Duration{0});
    return (release - executor->started_at()) / period;
  }

  ProbeOs os;
  Robot robot;
  RealTimeOptions options;
  ThreadRecords records;
  std::unique_ptr<RealTimeExecutor> executor;
};

TEST_F(RealTime, APeriodicThreadNeverShiftsItsPhase) {
  robot.add<Numbers>("numbers");
  robot.periodic("main", 10, 2ms, {"numbers"});
  start();
  ASSERT_TRUE(steps_of(0, 50));
  executor->stop();
  const auto& steps = records.of[0];
  std::int64_t before = -1;
  for (const StepRecord& s : steps) {
    const std::int64_t k = index_of(s.release, 2ms);
    ASSERT_GT(k, before);
    ASSERT_EQ(s.dt, 2ms * (before < 0 ? 1 : k - before)) << "release to release";
    ASSERT_GE(s.now, s.release);
    ASSERT_GE(s.completed, s.now);
    before = k;
  }
  EXPECT_EQ(stats().releases.value(), steps.size());
  EXPECT_EQ(stats().completions.value(), steps.size());
  EXPECT_GE(stats().skips.value() + steps.size(), static_cast<std::size_t>(before + 1));
}

TEST_F(RealTime, AnOverrunSkipsExactlyTheReleasesThatPassed) {
  Blocker& blocker = robot.add<Blocker>("blocker", {}, 3u);
  robot.periodic("main", 10, 1ms, {"blocker"});
  start();
  ASSERT_TRUE(until([&] { return blocker.blocked.load(); }));
  records.watched = &stats();
  os.sleep_until(os.now() + 20ms);
  blocker.go = true;
  ASSERT_TRUE(steps_of(0, 10));
  executor->stop();
  const auto& steps = records.of[0];
  const std::int64_t gap = index_of(steps[4].release, 1ms) - index_of(steps[3].release, 1ms);
  EXPECT_GE(gap, 20);
  EXPECT_EQ(steps[4].dt, gap * 1ms);
  EXPECT_GE(steps[4].release, steps[3].completed) << "none that had passed was run";
  EXPECT_EQ(stats().overruns.value(), stats().skips.value());
  for (std::size_t n = 4; n < steps.size(); ++n)
    ASSERT_EQ(records.skips[n] + n, static_cast<std::uint64_t>(index_of(steps[n].release, 1ms))) << "run or counted";
}

TEST_F(RealTime, CatchUpRunsTheOldestThatMayWaitAndSkipsTheRest) {
  Blocker& blocker = robot.add<Blocker>("blocker", {}, 3u);
  ThreadSpec& t = robot.periodic("main", 10, 1ms, {"blocker"});
  t.overrun = ThreadSpec::Overrun::catch_up;
  t.catch_up_max = 3;
  start();
  ASSERT_TRUE(until([&] { return blocker.blocked.load(); }));
  os.sleep_until(os.now() + 20ms);
  blocker.go = true;
  ASSERT_TRUE(steps_of(0, 12));
  executor->stop();
  const auto& steps = records.of[0];
  for (std::size_t n = 4; n < 7; ++n) {
    EXPECT_LE(steps[n].release, steps[3].completed) << "waited";
    EXPECT_EQ(steps[n].dt, steps[n].release - steps[n - 1].release);
    EXPECT_GT(index_of(steps[n].release, 1ms), index_of(steps[n - 1].release, 1ms));
  }
  EXPECT_GT(steps[7].release, steps[3].completed) << "more than three did not wait";
  EXPECT_GE(stats().skips.value(), 16u);
  EXPECT_GE(stats().overruns.value(), stats().skips.value() + 3) << "the three are overruns too, and not skips";
}

/// An instant as a trigger keeps it on this machine.
Time as_kept(Time t) {
  return InstantWord<>::time(InstantWord<>::of(t), [] { return hal::system_os().now(); });
}

TEST_F(RealTime, ACommitWakesTheThreadThatWaitsForItsTopic) {
  robot.add<Numbers>("numbers");
  Logger& logger = robot.add<Logger>("logger", {{"in", "numbers.out"}}, QueueOptions{.depth = 64});
  robot.periodic("writer", 10, 2ms, {"numbers"});
  robot.on_topics("reader", 20, {"numbers.out"}, {"logger"});
  start();
  ASSERT_TRUE(steps_of(1, 20));
  executor->stop();
  ASSERT_GE(logger.seen.size(), 20u);
  for (std::uint32_t i = 0; i < logger.seen.size(); ++i) ASSERT_EQ(logger.seen[i], i) << "all, in order";
  const auto& steps = records.of[1];
  EXPECT_EQ(steps[0].release, as_kept(records.of[0][0].completed)) << "released by the commit";
  for (std::size_t i = 1; i < steps.size(); ++i) {
    ASSERT_GE(steps[i].release, steps[i - 1].release);
    ASSERT_GT(steps[i].dt, Duration{0});
  }
  EXPECT_LE(stats(1).releases.value() + stats(1).coalesced.value(), records.of[0].size()) << "no trigger from nowhere";
  EXPECT_EQ(stats(1).timeouts.value(), 0u);
}

TEST_F(RealTime, TriggersDuringACycleBecomeOneAndAreCounted) {
  BellReader& reader = robot.add<BellReader>("reader", {}, true);
  robot.on_device("main", 10, {"reader"});
  start();
  reader.bell.ring();
  ASSERT_TRUE(until([&] { return reader.begun.load() == 1; }));
  for (int i = 0; i < 5; ++i) reader.bell.ring(0);  // without samples: these are five triggers, not more
  reader.go = true;
  ASSERT_TRUE(steps_of(0, 2));
  executor->stop();
  EXPECT_EQ(records.of[0].size(), 2u);
  EXPECT_EQ(stats().coalesced.value(), 4u);
  EXPECT_GT(records.of[0][1].release, records.of[0][0].now);
  EXPECT_LT(records.of[0][1].release, records.of[0][0].completed) << "of the first that waited";
}

TEST_F(RealTime, ADeviceWakesItsThreadFromAnyThread) {
  BellReader& reader = robot.add<BellReader>("reader");
  robot.on_device("main", 10, {"reader"});
  start();
  std::jthread kernel([&] {
    for (std::uint32_t i = 1; i <= 20; ++i) {
      reader.bell.ring();
      ASSERT_TRUE(until([&] { return reader.read.load() == i; }));
    }
  });
  kernel.join();
  executor->stop();
  EXPECT_EQ(reader.read.load(), 20u);
}

TEST_F(RealTime, WhatABoundedCollectLeavesIsReadWithoutAnotherWake) {
  BellReader& reader = robot.add<BellReader>("reader");  // two samples a cycle
  robot.on_device("main", 10, {"reader"});
  start();
  reader.bell.ring(7);
  ASSERT_TRUE(until([&] { return reader.read.load() == 7; }));
  executor->stop();
  EXPECT_EQ(records.of[0].size(), 4u);
}

TEST_F(RealTime, ATimeOutReleasesAndSaysSo) {
  BellReader& reader = robot.add<BellReader>("reader", {}, true);
  robot.on_device("main", 10, {"reader"}, 3ms);
  start();
  ASSERT_TRUE(until([&] { return reader.begun.load() == 1; }));
  os.sleep_until(os.now() + 10ms);  // the next cycle begins late and absorbs two more at least
  reader.go = true;
  ASSERT_TRUE(steps_of(0, 5));
  executor->stop();
  EXPECT_EQ(reader.read.load(), 0u);
  std::int64_t before = 0;  // the first is one time-out after the start
  for (const StepRecord& r : records.of[0]) {
    EXPECT_TRUE(r.timed_out);
    const std::int64_t k = index_of(r.release, 3ms);
    EXPECT_GT(k, before);
    EXPECT_EQ(r.dt, 3ms * (k - before));
    before = k;
  }
  EXPECT_EQ(stats().timeouts.value(), records.of[0].size());
  EXPECT_GE(stats().coalesced.value(), 2u);
  const auto passed = static_cast<std::uint64_t>(before) - records.of[0].size();
  EXPECT_GE(passed, 2u);
  EXPECT_LE(passed, stats().coalesced.value()) << "absorbed and counted; the last cycle's come after its release";
}

TEST_F(RealTime, StopEndsLongSleeps) {
  robot.add<Numbers>("hourly");
  robot.add<Numbers>("later");
  robot.add<BellReader>("bell");
  robot.add<BellReader>("hour_bell");
  robot.periodic("hourly", 10, 3600s, {"hourly"});
  robot.periodic("later", 10, 1ms, {"later"}).phase = 3600s;
  robot.on_device("bell", 10, {"bell"});
  robot.on_device("hour_bell", 10, {"hour_bell"}, 3600s);
  start();
  ASSERT_TRUE(steps_of(0, 1));
  executor->stop();
  EXPECT_TRUE(records.of[1].empty());
  EXPECT_LE(os.longest_sleep(), Duration{50ms}) << "of those that a wake cannot end";
}

/// The system's complaints about a thread that asks for this; nothing where it grants all.
std::vector<std::string> missing_for(const std::string& thread, int priority, const std::vector<int>& cpus) {
  const auto started = hal::system_os().start_thread({.name = thread, .fifo_priority = priority, .cpus = cpus}, [] {});
  EXPECT_TRUE(started);
  const std::string missing = started ? (*started)->shortfall() : "";
  return missing.empty() ? std::vector<std::string>{} : std::vector{"thread " + thread + ": " + missing};
}

TEST_F(RealTime, WithoutPrivilegesItRunsAndSaysWhatIsMissing) {
  os.denies = true;
  const auto missing = missing_for("main", 10, {1023});
  ASSERT_THAT(missing, ElementsAre(::testing::HasSubstr("CPU set"))) << "no system has so many";
  robot.add<Numbers>("numbers");
  robot.periodic("main", 10, 1ms, {"numbers"}).cpus = {1023};
  start();
  ASSERT_TRUE(steps_of(0, 3));
  executor->stop();
  EXPECT_THAT(executor->shortfalls(), ElementsAre(::testing::StartsWith("memory is not locked: "), missing[0]));
}

TEST_F(RealTime, NoStepIsTakenBeforeAllThreadsAreThere) {
  os.before_further_threads = 30ms;  // thirty periods
  robot.add<Numbers>("first");
  robot.add<BellReader>("second");
  robot.periodic("first", 10, 1ms, {"first"});
  robot.on_device("second", 10, {"second"}, 1ms);
  const Time begin = os.now();
  start();
  EXPECT_GE(executor->started_at(), begin + os.before_further_threads);
  ASSERT_TRUE(steps_of(0, 3));
  ASSERT_TRUE(steps_of(1, 3));
  executor->stop();
  EXPECT_GE(records.of[0][0].now, executor->started_at());
  EXPECT_GT(records.of[1][0].release, executor->started_at());
}

TEST_F(RealTime, StrictlyNothingRunsWhereAPrivilegeIsMissing) {
  os.denies = true;
  os.before_further_threads = 5ms;
  options.strict = true;
  robot.add<Numbers>("numbers");
  robot.add<BellReader>("bell");
  robot.periodic("main", 10, 1ms, {"numbers"}).cpus = {1023};
  robot.on_device("bell", 10, {"bell"}, 1ms);
  const auto started = try_to_start();
  ASSERT_FALSE(started);
  EXPECT_EQ(started.error().code, hal::Errc::denied);
  std::vector<std::string> missing{std::string("memory is not locked: ") + hal::to_string(hal::Errc::denied)};
  for (const auto& m : {missing_for("main", 10, {1023}), missing_for("bell", 10, {})})
    missing.insert(missing.end(), m.begin(), m.end());
  EXPECT_THAT(executor->shortfalls(), ::testing::ElementsAreArray(missing)) << "and it is known what";
  os.sleep_until(os.now() + 5ms);
  EXPECT_EQ(records.count[0].load() + records.count[1].load(), 0u);
}

TEST_F(RealTime, StrictlyItRunsWhereNothingIsMissing) {
  options.strict = true;
  options.keep_awake = options.fixed_priority = false;  // which not every machine grants
  robot.add<Numbers>("numbers");
  robot.periodic("main", 10, 1ms, {"numbers"});
  start();
  EXPECT_TRUE(steps_of(0, 3));
}

TEST_F(RealTime, AParameterChangesBetweenTwoSteps) {
  class Gain final : public Module {
   public:
    void declare(Declaration& d) override { d.param("gain", gain_, {.min = 0.0, .max = 2.0}); }
    StepStatus step(const Step&) noexcept override {
      seen.store(gain_);
      return StepStatus::ok;
    }
    hal::Wide<double> seen;

   private:
    double gain_ = 1.0;
  };
  Gain& gain = robot.add<Gain>("gain");
  robot.periodic("main", 10, 1ms, {"gain"});
  start();
  const auto ticket = robot.graph().set_param("gain", "gain", ParamValue(1.5));
  ASSERT_TRUE(ticket);
  EXPECT_TRUE(until([&] { return gain.seen.load() == 1.5; }));
  EXPECT_TRUE(robot.graph().effect(*ticket).has_value());
  executor->stop();
}

TEST_F(RealTime, TheGuardianStopsTheDeviceWhenTheCommanderFallsSilent) {
  class Commander final : public Module {
   public:
    void declare(Declaration& d) override { d.out("out", out_); }
    StepStatus step(const Step& step) noexcept override {
      if (silent.load()) return StepStatus::stale;
      msg::ActuatorCommand& c = out_.loan();
      c.stamp = step.now;
      c.count = c.armed = 1;
      c.value[0] = 0.5;
      return StepStatus::ok;
    }
    std::atomic<bool> silent{false};

   private:
    Out<msg::ActuatorCommand> out_;
  };
  class Watch final : public Module {
   public:
    void declare(Declaration& d) override { d.in("in", in_); }
    StepStatus step(const Step&) noexcept override {
      if (in_.get()) mode.store(in_.get()->mode);
      return StepStatus::ok;
    }
    std::atomic<msg::GuardianMode> mode{msg::GuardianMode::standby};

   private:
    In<msg::GuardianState> in_;
  };
  FakeActuators& motors = robot.board.add("motors", os);
  Commander& commander = robot.add<Commander>("commander");
  Watch& watch = robot.add<Watch>("watch", {{"in", "guardian.motors"}});
  robot.periodic("control", 10, 2ms, {"commander"});
  robot.on_topics("watch", 5, {"guardian.motors"}, {"watch"});
  robot.spec.actuators.push_back({"motors", {"commander.out", 0}, 1, 0, 1, 0, 200ms, ActuatorSpec::Safe::stop, 0});
  start();
  ASSERT_TRUE(until([&] { return watch.mode.load() == msg::GuardianMode::active; }));
  commander.silent = true;
  ASSERT_TRUE(until([&] { return watch.mode.load() == msg::GuardianMode::safe; }));
  executor->stop();
  ASSERT_FALSE(motors.events.empty());
  EXPECT_TRUE(motors.events.back().stopped);
  const std::uint32_t guardian = robot.graph().find_module("guardian"), module = robot.graph().find_module("commander");
  Time last_command{};
  for (const StepRecord& r : records.of[module])
    if (r.status == StepStatus::ok) last_command = r.completed;
  for (const FakeActuators::Event& e : motors.events)
    if (e.at - last_command >= 200ms) {
      EXPECT_TRUE(e.stopped);
    }
  EXPECT_GT(records.of[guardian].size(), 2u);
}

TEST_F(RealTime, ItsThreadsCallNothingButTheOs) {
  if (!sinew::trap::is_set()) GTEST_SKIP() << "no trap in this build";
  robot.add<Numbers>("numbers");
  robot.add<Twin>("twin");
  robot.add<TwinReader>("reader", {{"a", "twin.a"}, {"b", "twin.b"}});
  robot.add<Logger>("logger", {{"in", "numbers.out"}}, QueueOptions{.depth = 4, .overflow = Overflow::drop_newest});
  robot.periodic("writer", 10, 1ms, {"numbers", "twin"});
  robot.on_topics("reader", 20, {"twin.a"}, {"reader", "logger"}, 700us);
  start();
  ASSERT_TRUE(steps_of(0, 100));
  ASSERT_TRUE(robot.graph().set_enabled("twin", false));
  ASSERT_TRUE(steps_of(0, 200));
  executor->stop();
  EXPECT_EQ(os.calls(), 0u);
}

// ---- Trigger

TEST(Trigger, TakesAllThatWaitWithTheInstantsOfTheFirstAndTheLatest) {
  ProbeOs os;
  Trigger trigger(os);
  EXPECT_EQ(trigger.take().count, 0u);
  const Time t = os.now();
  trigger.fire(t + 1us);
  trigger.fire(t + 2us);
  trigger.fire(t + 3us);
  EXPECT_TRUE(trigger.wait(Time{0})) << "a trigger comes before the deadline";
  const auto taken = trigger.take();
  EXPECT_EQ(taken.count, 3u);
  EXPECT_EQ(taken.first, as_kept(t + 1us));
  EXPECT_EQ(taken.latest, as_kept(t + 3us));
  trigger.fire(t + 4us);
  EXPECT_EQ(trigger.take().first, as_kept(t + 4us)) << "of no trigger that was taken";
  EXPECT_FALSE(trigger.wait(Time{1}));
}

TEST(Trigger, LosesNoneOfManyThreads) {
  constexpr std::uint32_t kFires = 20'000, kThreads = 3;
  ProbeOs os;
  Trigger trigger(os);
  const Time begin = os.now();
  std::vector<std::jthread> threads;
  for (std::uint32_t t = 0; t < kThreads; ++t)
    threads.emplace_back([&] {
      for (std::uint32_t i = 0; i < kFires; ++i) {
        trigger.wake();
        if (i % 64 == 0) std::this_thread::yield();  // so that the owner falls asleep now and then
      }
    });
  std::uint32_t taken = 0;
  while (taken < kFires * kThreads) {
    ASSERT_TRUE(trigger.wait(hal::kNever));
    const auto t = trigger.take();
    ASSERT_GT(t.count, 0u);
    ASSERT_GE(t.first, begin);
    ASSERT_LE(t.first, os.now());
    taken += t.count;
  }
  threads.clear();
  EXPECT_EQ(taken, kFires * kThreads);
  EXPECT_EQ(trigger.waiting(), 0u);
}

TEST(Trigger, AnInstantIsNeverThatOfATriggerTakenBefore) {
  // One thread fires 1, 2, 3, ... as instants; of the instants taken together, the first is never one of an earlier
  // batch.
  ProbeOs os;
  Trigger trigger(os);
  constexpr std::int64_t kFires = 50'000;
  std::jthread firer([&] {
    for (std::int64_t i = 1; i <= kFires; ++i) trigger.fire(Time{i});
  });
  std::int64_t taken = 0;
  while (taken < kFires) {
    ASSERT_TRUE(trigger.wait(hal::kNever));
    const auto t = trigger.take();
    ASSERT_GT(t.first.ns, taken) << "stale";
    taken += t.count;
  }
}

}  // namespace
}  // namespace sinew::rt::real_time_test
