// The real-time executor's schedule to the nanosecond: its thread runs on a clock that the test moves.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>

#include "graph_fixture.hpp"
#include "hal/wide.hpp"
#include "rt/exec/real_time_executor.hpp"
#include "scripted_os.hpp"
#include "until.hpp"

namespace sinew::rt::executor_timing_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// The test defines its steps.
class Scripted final : public Module {
 public:
  using Step_ = std::function<void(const Step&)>;
  explicit Scripted(Step_ step) : step_(std::move(step)) {}
  void declare(Declaration&) override {}
  StepStatus step(const Step& step) noexcept override {
    step_(step);
    return StepStatus::ok;
  }

 private:
  Step_ step_;
};

class Bell final : public hal::Device {
 public:
  Time ready_at() const noexcept override { return hal::kNever; }
  void set_wake(hal::Wake* w) noexcept override { wake = w; }
  void ring() { wake->wake(); }
  hal::Wake* wake = nullptr;
};

class ScriptedDriver final : public DriverModule {
 public:
  explicit ScriptedDriver(Scripted::Step_ step) : step_(std::move(step)) {}
  void declare(Declaration&) override {}
  StepStatus step(const Step& step) noexcept override {
    step_(step);
    return StepStatus::ok;
  }
  hal::Device* device() override { return &bell; }
  Bell bell;

 private:
  Scripted::Step_ step_;
};

class FirstSteps final : public RunObserver {
 public:
  FirstSteps() { all.reserve(1000); }
  void completed(const StepRecord& r) noexcept override {
    if (all.size() == all.capacity()) return;
    all.push_back(r);
    count.store(all.size(), std::memory_order_release);
  }
  std::vector<StepRecord> all;
  std::atomic<std::size_t> count{0};
};

class ExecutorTiming : public ::testing::Test {
 protected:
  ExecutorTiming() { robot.virtual_time = false; }
  /// The first step of the only thread begins at start() at the earliest, a millisecond from now.
  Time start() const { return origin_ + 1ms; }

  ThreadSpec& periodic(Duration period, Scripted::Step_ step) {
    robot.add<Scripted>("scripted", {}, std::move(step));
    return robot.periodic("main", 10, period, {"scripted"});
  }
  /// Never sleeps; after every `often` cycles of 10.5 ms it is frozen.
  void never_sleeps(std::uint32_t often, Duration frozen) {
    ThreadSpec& t = periodic(10ms, [this, often, frozen](const Step& s) {
      os.work(10500us);
      if (s.number % often == often - 1) os.freeze(frozen);
    });
    t.overrun = ThreadSpec::Overrun::catch_up;
  }
  ScriptedDriver& on_bell(Duration timeout, Scripted::Step_ step) {
    ScriptedDriver& driver = robot.add<ScriptedDriver>("driver", {}, std::move(step));
    robot.on_device("main", 10, {"driver"}, timeout);
    if (!hal::kReadsWideAtOnce) early_ = 255ns;  // a trigger's instant is rounded down (rt/exec/instant_word.hpp)
    return driver;
  }
  void run(std::size_t count) {
    options.start_delay = 1ms;
    options.runner.observer = &steps;
    executor = std::make_unique<RealTimeExecutor>(robot.build(), os, options);
    ASSERT_TRUE(executor->start());
    until([&] { return steps.count.load(std::memory_order_acquire) >= count; });
    executor->stop();
    ASSERT_GE(steps.all.size(), count);
    steps.all.resize(count);
  }
  /// Since the start, in units of `unit`; a release that lies between two is -1.
  std::vector<std::int64_t> releases(Duration unit, Duration phase = {}) const {
    std::vector<std::int64_t> all;
    for (const StepRecord& s : steps.all) {
      const Duration since = s.release - start() - phase + early_;
      all.push_back(since % unit <= early_ ? since / unit : -1);
    }
    return all;
  }
  std::vector<bool> timed_out() const {
    std::vector<bool> all;
    for (const StepRecord& s : steps.all) all.push_back(s.timed_out);
    return all;
  }
  const ThreadStats& stats() { return executor->runner().thread_stats(0); }

  ScriptedOs os;
  Robot robot;
  FirstSteps steps;
  RealTimeOptions options;
  std::unique_ptr<RealTimeExecutor> executor;

 private:
  const Time origin_ = os.now();
  Duration early_{};  // so much too early a release may be
};

// ---- overruns

TEST_F(ExecutorTiming, SkipDropsTheReleasesThatMetTheCycleAndNoOther) {
  periodic(1ms, [this](const Step& s) { os.work(s.number == 3 ? 5200us : 100us); });
  run(7);
  EXPECT_THAT(releases(1ms), ElementsAre(0, 1, 2, 3, 9, 10, 11));
  EXPECT_EQ(steps.all[4].dt, 6ms);
  EXPECT_EQ(steps.all[5].dt, 1ms);
  EXPECT_EQ(stats().overruns.value(), 5u);
  EXPECT_EQ(stats().skips.value(), 5u);
}

TEST_F(ExecutorTiming, ACycleThatEndsAtAReleaseIsNoOverrun) {
  periodic(1ms, [this](const Step& s) { os.work(s.number == 1 ? 1ms : 100us); });
  run(4);
  EXPECT_THAT(releases(1ms), ElementsAre(0, 1, 2, 3));
  EXPECT_EQ(stats().overruns.value(), 0u);
}

TEST_F(ExecutorTiming, CatchUpRunsTheOldestReleasesAtOnceAndSkipsTheRest) {
  ThreadSpec& t = periodic(1ms, [this](const Step& s) { os.work(s.number == 3 ? 5200us : 100us); });
  t.overrun = ThreadSpec::Overrun::catch_up;
  t.catch_up_max = 2;
  run(9);
  EXPECT_THAT(releases(1ms), ElementsAre(0, 1, 2, 3, 4, 5, 9, 10, 11));
  EXPECT_EQ(steps.all[4].now, steps.all[3].completed);
  EXPECT_EQ(steps.all[5].now, steps.all[4].completed);
  EXPECT_EQ(steps.all[4].dt, 1ms);
  EXPECT_EQ(steps.all[6].dt, 4ms);
  EXPECT_EQ(stats().overruns.value(), 5u);
  EXPECT_EQ(stats().skips.value(), 3u);
}

TEST_F(ExecutorTiming, CatchUpIsBoundedWhereEveryCycleIsTooLong) {
  ThreadSpec& t = periodic(1ms, [this](const Step&) { os.work(1500us); });
  t.overrun = ThreadSpec::Overrun::catch_up;
  t.catch_up_max = 3;
  run(300);
  for (const StepRecord& s : steps.all) ASSERT_LE(s.now - s.release, 3 * 1500us) << "three wait, no more";
  EXPECT_EQ(releases(1ms).back(), 444) << "of those due when the last began, at 448.5 ms, the oldest that might wait";
}

TEST_F(ExecutorTiming, ALateWakeUpShiftsNothing) {
  periodic(1ms, [this](const Step&) { os.work(100us); }).phase = 300us;
  os.oversleep(2, 400us);
  os.oversleep(4, 1700us);  // over the next release
  run(8);
  EXPECT_THAT(releases(1ms, 300us), ElementsAre(0, 1, 2, 3, 4, 6, 7, 8));
  EXPECT_EQ(steps.all[2].now - steps.all[2].release, 400us);
  EXPECT_EQ(steps.all[3].now, steps.all[3].release);
  EXPECT_EQ(stats().lateness.max(), 1700us);
  EXPECT_EQ(stats().skips.value(), 1u);
}

// ---- triggers and time-outs

TEST_F(ExecutorTiming, TriggersBeforeACycleBeginsAreOne) {
  ScriptedDriver& driver = on_bell({}, [](const Step&) {});
  os.at(start() + 2ms, [&] {
    for (int i = 0; i < 4; ++i) driver.bell.ring();
  });
  os.at(start() + 5ms, [&] { driver.bell.ring(); });
  run(2);
  EXPECT_THAT(releases(1ms), ElementsAre(2, 5));
  EXPECT_EQ(stats().coalesced.value(), 3u);
}

TEST_F(ExecutorTiming, TriggersDuringACycleMakeOneMoreReleasedByTheFirst) {
  ScriptedDriver& driver = on_bell({}, [this](const Step& s) { os.work(s.number == 0 ? 10ms : 100us); });
  for (const auto at : {1ms, 3ms, 4ms, 9ms, 20ms}) os.at(start() + at, [&] { driver.bell.ring(); });
  run(3);
  EXPECT_THAT(releases(1ms), ElementsAre(1, 3, 20));
  EXPECT_EQ(steps.all[1].now, start() + 11ms) << "as soon as the first is over";
  EXPECT_EQ(stats().coalesced.value(), 2u);
}

TEST_F(ExecutorTiming, TimeOutsCountFromTheLastTriggerOrTimeOut) {
  ScriptedDriver& driver = on_bell(3ms, [](const Step&) {});
  os.at(start() + 7ms, [&] { driver.bell.ring(); });
  os.at(start() + 10ms, [&] { driver.bell.ring(); });  // at the instant of the time-out: the trigger comes first
  run(6);
  EXPECT_THAT(releases(1ms), ElementsAre(3, 6, 7, 10, 13, 16));
  EXPECT_THAT(timed_out(), ElementsAre(true, true, false, false, true, true));
  EXPECT_THAT(steps.all[0].dt, 3ms);
  EXPECT_THAT(steps.all[2].dt, 1ms);
}

TEST_F(ExecutorTiming, TimeOutsDuringACycleMakeOneMoreAndNoStampede) {
  on_bell(3ms, [this](const Step& s) { os.work(s.number == 0 ? 10ms : 100us); });
  run(4);
  // From 3 to 13 the first runs; 6 makes the one that waits, 9 and 12 are absorbed.
  EXPECT_THAT(releases(1ms), ElementsAre(3, 6, 15, 18));
  EXPECT_THAT(timed_out(), ElementsAre(true, true, true, true));
  EXPECT_EQ(stats().coalesced.value(), 2u);
}

TEST_F(ExecutorTiming, ATriggerDuringACycleHoldsTheTimeOutBack) {
  ScriptedDriver& driver = on_bell(3ms, [this](const Step& s) { os.work(s.number == 0 ? 4500us : 100us); });
  os.at(start() + 5ms, [&] { driver.bell.ring(); });
  run(4);
  EXPECT_THAT(releases(1ms), ElementsAre(3, 5, 8, 11));
  EXPECT_THAT(timed_out(), ElementsAre(true, false, true, true));
  EXPECT_EQ(stats().coalesced.value(), 0u);
}

// ---- time without the processor

TEST_F(ExecutorTiming, AFrozenThreadThatNeverSleepsIsThrottledAndNamedSo) {
  never_sleeps(91, 50ms);  // as the kernel: 950 ms with the processor, 50 without
  run(300);
  EXPECT_GE(stats().throttled.count.value(), 3u);
  EXPECT_EQ(stats().taken.count.value(), 0u);
  EXPECT_EQ(stats().throttled.min_ns.value(), 50'000'000);
  EXPECT_EQ(stats().throttled.max_ns.value(), 50'000'000);
}

TEST_F(ExecutorTiming, TheSameGapOfAThreadThatSleepsIsSomebodyElses) {
  periodic(10ms, [this](const Step& s) {
    os.work(5ms);
    if (s.number % 90 == 89) os.freeze(50ms);
  });
  run(300);
  EXPECT_EQ(stats().throttled.count.value(), 0u);
  EXPECT_GE(stats().taken.count.value(), 3u);
}

class OtherGaps : public ExecutorTiming, public ::testing::WithParamInterface<Duration> {};
TEST_P(OtherGaps, AreNotTheThrottles) {
  never_sleeps(91, GetParam());
  run(200);
  EXPECT_EQ(stats().throttled.count.value(), 0u);
  EXPECT_GE(stats().taken.count.value(), 2u);
  EXPECT_EQ(stats().taken.max_ns.value(), GetParam().count());
}
INSTANTIATE_TEST_SUITE_P(Lengths, OtherGaps, ::testing::Values(65ms, 100ms));  // twice its length, but all at once

TEST_F(ExecutorTiming, AKernelWithAnotherThrottleIsKnownByIt) {
  options.throttle = {270ms, 60ms};
  never_sleeps(20, 60ms);
  run(100);
  EXPECT_GE(stats().throttled.count.value(), 4u);
  EXPECT_EQ(stats().taken.count.value(), 0u);
}

TEST_F(ExecutorTiming, OneLongStepIsThrottledOnceASecond) {
  periodic(10ms, [this](const Step& s) {
    if (s.number != 3) return;
    for (int second = 0; second < 3; ++second) os.work(950ms), os.freeze(51ms);
  });
  run(5);
  EXPECT_EQ(stats().throttled.count.value(), 3u);
  EXPECT_EQ(stats().throttled.max_ns.value(), 51'000'000);
  EXPECT_EQ(stats().taken.count.value(), 0u);
}

TEST_F(ExecutorTiming, AStepThatOnlyWorksLongHasNoGap) {
  periodic(10ms, [this](const Step& s) { os.work(s.number == 3 ? 2s : 1ms); });
  run(6);
  EXPECT_EQ(stats().throttled.count.value(), 0u);
  EXPECT_EQ(stats().taken.count.value(), 0u);
}

TEST_F(ExecutorTiming, AWakeUpThatComesMuchTooLateIsAGap) {
  periodic(10ms, [this](const Step&) { os.work(1ms); });
  os.oversleep(5, 55ms);
  os.oversleep(8, 39ms);  // late, but no gap
  run(12);
  EXPECT_EQ(stats().taken.count.value(), 1u);
  EXPECT_EQ(stats().taken.max_ns.value(), 55'000'000);
  EXPECT_EQ(stats().throttled.count.value(), 0u);
}

TEST_F(ExecutorTiming, ReleasesThatWaitedForALongCycleAreNoGap) {
  ThreadSpec& t = periodic(10ms, [this](const Step& s) { os.work(s.number == 3 ? 200ms : 1ms); });
  t.overrun = ThreadSpec::Overrun::catch_up;
  t.catch_up_max = 5;
  run(12);
  EXPECT_GE(stats().lateness.max(), 150ms) << "they were late";
  EXPECT_EQ(stats().taken.count.value(), 0u);
}

TEST_F(ExecutorTiming, WithoutFixedPriorityNothingIsThrottled) {
  options.fixed_priority = false;
  never_sleeps(91, 50ms);
  run(200);
  EXPECT_EQ(stats().throttled.count.value(), 0u);
  EXPECT_GE(stats().taken.count.value(), 2u);
}

TEST(GapWatch, AThreadInALongStepIsBusyForWhoeverWakesLate) {
  ScriptedOs os;
  GapWatch watch(os, Throttle{});
  watch.begin(os.now());
  os.freeze(5ms);
  EXPECT_FALSE(watch.woke(os.now(), os.now()));
  os.work(500ms);
  EXPECT_FALSE(watch.busy(os.now())) << "not long enough for the kernel";
  os.work(450ms);
  os.freeze(50ms);
  EXPECT_TRUE(watch.busy(os.now())) << "it is frozen itself";
  EXPECT_TRUE(watch.ran(os.now()));
  EXPECT_TRUE(watch.busy(os.now()));
  EXPECT_FALSE(watch.busy(os.now() + 2s)) << "it sleeps since";
}

TEST(GapWatch, AThreadThatSleepsAFifthOfItsTimeIsNotBusy) {
  ScriptedOs os;
  GapWatch watch(os, Throttle{});
  watch.begin(os.now());
  for (int i = 0; i < 300; ++i) {
    os.freeze(2ms);  // asleep of its own will
    EXPECT_FALSE(watch.woke(os.now(), os.now()));
    os.work(8ms);
    EXPECT_FALSE(watch.ran(os.now()));
    ASSERT_FALSE(watch.busy(os.now()));
  }
}

// ---- privileges

TEST_F(ExecutorTiming, ProcessorsAreKeptAwakeWhileItRuns) {
  bool seen = false;
  periodic(1ms, [&](const Step&) { seen = os.awake == 1; });
  run(3);
  EXPECT_TRUE(seen);
  EXPECT_EQ(os.awake, 0);
  EXPECT_THAT(executor->shortfalls(), IsEmpty());
}

TEST_F(ExecutorTiming, ARefusalToKeepThemAwakeIsSaid) {
  os.keeps_awake = false;
  periodic(1ms, [](const Step&) {});
  run(1);
  EXPECT_THAT(executor->shortfalls(),
              ElementsAre("processors may sleep deeply and wake late: scripted latency: permission denied"));
}

TEST_F(ExecutorTiming, WhereThereIsNoMeansOfKeepingThemAwakeNothingIsMissing) {
  os.has_awake_means = false;
  periodic(1ms, [](const Step&) {});
  run(1);
  EXPECT_THAT(executor->shortfalls(), IsEmpty());
}

TEST_F(ExecutorTiming, ItIsNotAskedForWhereTheOptionIsOff) {
  options.keep_awake = false;
  os.keeps_awake = false;
  periodic(1ms, [](const Step&) {});
  run(1);
  EXPECT_THAT(executor->shortfalls(), IsEmpty());
}

}  // namespace
}  // namespace sinew::rt::executor_timing_test
