// Schedules computed by hand from rt/README.md, checked by number. Times are plain nanoseconds.
#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "rt/exec/schedule.hpp"

namespace sinew::rt::schedule_hand_test {
namespace {

using Trigger = ThreadSpec::Trigger;
using Log = std::vector<std::string>;

/// Writes down the events: "3 start b0", "5 end b0"; thread 0 is "a". Execution times are given per thread: one list of
/// steps, repeated.
class Rig : public ScheduleClient {
 public:
  std::vector<ScheduleThread> threads;
  std::vector<std::vector<std::int64_t>> takes;
  std::map<std::string, std::uint32_t> triggers_at_end, triggers_at_start;  // "b0" -> thread
  Log log;
  std::map<std::string, std::int64_t> releases;  // "a0@12" -> release instant
  std::unique_ptr<Schedule> schedule;

  /// Adds a thread; returns it for further settings.
  ScheduleThread& periodic(int priority, std::int64_t period, std::int64_t phase, std::vector<std::int64_t> exec) {
    threads.push_back({});
    threads.back().priority = priority;
    threads.back().period = Duration{period};
    threads.back().phase = Duration{phase};
    takes.push_back(std::move(exec));
    return threads.back();
  }
  ScheduleThread& triggered(Trigger by, int priority, std::int64_t timeout, std::vector<std::int64_t> exec) {
    ScheduleThread& t = periodic(priority, 0, 0, std::move(exec));
    t.trigger = by;
    t.timeout = Duration{timeout};
    return t;
  }
  void prepare(std::uint32_t cores = 1) {
    schedule = std::make_unique<Schedule>(threads, cores, Time{0}, *this);
    next_.assign(threads.size(), 0);
  }
  const Log& run(std::int64_t until, std::uint32_t cores = 1) {
    if (!schedule) prepare(cores);
    schedule->run_until(Time{until});
    return log;
  }
  const ScheduleCounters& counters(std::uint32_t thread) const { return schedule->counters(thread); }

 private:
  static std::string name(std::uint32_t thread, std::uint32_t module) {
    return std::string(1, static_cast<char>('a' + thread)) + std::to_string(module);
  }
  Duration start(std::uint32_t thread, std::uint32_t module, const CycleInfo& cycle, Time now) noexcept override {
    const std::string step = name(thread, module);
    log.push_back(std::to_string(now.ns) + " start " + step + (cycle.timed_out ? " timed out" : ""));
    releases[step + "@" + std::to_string(now.ns)] = cycle.release.ns;
    if (auto t = triggers_at_start.find(step); t != triggers_at_start.end()) schedule->trigger(t->second);
    const auto& list = takes[thread];
    return Duration{list[next_[thread]++ % list.size()]};
  }
  void complete(std::uint32_t thread, std::uint32_t module, Time now) noexcept override {
    log.push_back(std::to_string(now.ns) + " end " + name(thread, module));
    if (auto t = triggers_at_end.find(name(thread, module)); t != triggers_at_end.end()) schedule->trigger(t->second);
  }
  std::vector<std::size_t> next_;
};

TEST(ScheduleByHand, PeriodicReleasesComeAtStartPlusPhasePlusMultiplesOfThePeriod) {
  Rig r;
  r.periodic(1, 10, 2, {3});
  EXPECT_EQ(r.run(25), (Log{"2 start a0", "5 end a0", "12 start a0", "15 end a0", "22 start a0", "25 end a0"}));
  EXPECT_EQ(r.counters(0).releases, 3u);
  EXPECT_EQ(r.counters(0).completions, 3u);
  EXPECT_EQ(r.counters(0).overruns, 0u);
}

TEST(ScheduleByHand, HigherPriorityPreemptsAndTheRestOfTheStepIsDoneLater) {
  Rig r;
  r.periodic(2, 5, 1, {2});
  r.periodic(1, 20, 0, {6});
  EXPECT_EQ(r.run(18), (Log{"0 start b0", "1 start a0", "3 end a0", "6 start a0", "8 end a0", "10 end b0",
                            "11 start a0", "13 end a0", "16 start a0", "18 end a0"}));
  EXPECT_EQ(r.counters(1).preemptions, 2u);
  EXPECT_EQ(r.counters(0).preemptions, 0u);
}

TEST(ScheduleByHand, EqualPriorityNeverPreempts) {
  Rig r;
  r.periodic(1, 10, 2, {3});
  r.periodic(1, 10, 0, {5});
  EXPECT_EQ(r.run(18), (Log{"0 start b0", "5 end b0", "5 start a0", "8 end a0", "10 start b0", "15 end b0",
                            "15 start a0", "18 end a0"}));
  EXPECT_EQ(r.counters(0).preemptions + r.counters(1).preemptions, 0u);
}

TEST(ScheduleByHand, EqualPriorityGoesByIndexWhenNeitherHasBegun) {
  Rig r;
  r.periodic(1, 100, 0, {4});
  r.periodic(1, 100, 0, {4});
  r.periodic(2, 100, 0, {1});
  EXPECT_EQ(r.run(9), (Log{"0 start c0", "1 end c0", "1 start a0", "5 end a0", "5 start b0", "9 end b0"}));
}

TEST(ScheduleByHand, ACycleBetweenTwoStepsCanBePreemptedToo) {
  Rig r;
  r.periodic(2, 100, 2, {1});
  r.periodic(1, 100, 0, {2, 2}).modules = 2;
  EXPECT_EQ(r.run(10), (Log{"0 start b0", "2 end b0", "2 start a0", "3 end a0", "3 start b1", "5 end b1"}));
  EXPECT_EQ(r.counters(1).preemptions, 1u);
}

TEST(ScheduleByHand, SkippedReleasesAreDroppedAndTheNextOneKeepsItsPhase) {
  Rig r;
  r.periodic(1, 4, 0, {9});
  EXPECT_EQ(r.run(24), (Log{"0 start a0", "9 end a0", "12 start a0", "21 end a0", "24 start a0"}));
  EXPECT_EQ(r.counters(0).releases, 3u);
  EXPECT_EQ(r.counters(0).overruns, 4u);  // 4, 8, 16, 20
  EXPECT_EQ(r.counters(0).skips, 4u);
}

TEST(ScheduleByHand, CatchUpKeepsABoundedNumberOfReleasesWithTheirInstants) {
  Rig r;
  ScheduleThread& t = r.periodic(1, 4, 0, {13, 1, 1, 1});
  t.overrun = ThreadSpec::Overrun::catch_up;
  t.catch_up_max = 2;
  EXPECT_EQ(r.run(17), (Log{"0 start a0", "13 end a0", "13 start a0", "14 end a0", "14 start a0", "15 end a0",
                            "16 start a0", "17 end a0"}));
  EXPECT_EQ(r.releases["a0@13"], 4);
  EXPECT_EQ(r.releases["a0@14"], 8);
  EXPECT_EQ(r.releases["a0@16"], 16);
  EXPECT_EQ(r.counters(0).overruns, 3u);  // 4, 8, 12
  EXPECT_EQ(r.counters(0).skips, 1u);     // 12
  EXPECT_EQ(r.counters(0).releases, 4u);
}

TEST(ScheduleByHand, TriggersDuringACycleCoalesceToOne) {
  Rig r;
  r.periodic(3, 2, 0, {1});
  r.triggered(Trigger::topics, 1, 0, {5});
  r.triggers_at_end["a0"] = 1;
  EXPECT_EQ(r.run(11), (Log{"0 start a0", "1 end a0", "1 start b0", "2 start a0", "3 end a0", "4 start a0", "5 end a0",
                            "6 start a0", "7 end a0", "8 start a0", "9 end a0", "10 end b0", "10 start a0", "11 end a0",
                            "11 start b0"}));
  EXPECT_EQ(r.releases["b0@11"], 3);       // the first trigger that came after the first cycle had begun
  EXPECT_EQ(r.counters(1).coalesced, 4u);  // 5, 7, 9 by the waiting cycle, 11 by the one that has not begun
  EXPECT_EQ(r.counters(1).preemptions, 4u);
  EXPECT_EQ(r.counters(1).releases, 2u);
}

TEST(ScheduleByHand, TimeOutCountsFromTheLastTriggerOrTimeOut) {
  Rig r;
  r.triggered(Trigger::topics, 2, 5, {1});
  r.periodic(1, 100, 11, {1});
  r.triggers_at_end["b0"] = 0;
  EXPECT_EQ(r.run(17), (Log{"5 start a0 timed out", "6 end a0", "10 start a0 timed out", "11 end a0", "11 start b0",
                            "12 end b0", "12 start a0", "13 end a0", "17 start a0 timed out"}));
  EXPECT_EQ(r.counters(0).timeouts, 3u);
  EXPECT_EQ(r.counters(0).releases, 4u);
}

TEST(ScheduleByHand, ACommitAtTheInstantOfTheTimeOutComesFirst) {
  Rig r;
  r.triggered(Trigger::topics, 2, 5, {1});
  r.periodic(1, 100, 0, {5});
  r.triggers_at_end["b0"] = 0;
  EXPECT_EQ(r.run(6), (Log{"0 start b0", "5 end b0", "5 start a0", "6 end a0"}));
  EXPECT_EQ(r.counters(0).timeouts, 0u);
}

TEST(ScheduleByHand, ATimeOutAbsorbedByABegunCycleMakesTheNextOneTimedOut) {
  Rig r;
  r.triggered(Trigger::topics, 1, 5, {7});
  r.periodic(2, 100, 0, {1});
  r.triggers_at_end["b0"] = 0;
  EXPECT_EQ(r.run(15), (Log{"0 start b0", "1 end b0", "1 start a0", "8 end a0", "8 start a0 timed out", "15 end a0",
                            "15 start a0 timed out"}));
  EXPECT_EQ(r.releases["a0@8"], 6);
  EXPECT_EQ(r.releases["a0@15"], 11);
}

TEST(ScheduleByHand, OnTwoCoresAPinnedThreadMovesAnotherOneWhichIsNoPreemption) {
  Rig r;
  r.periodic(3, 100, 2, {4}).cpus = {0};
  r.periodic(2, 100, 0, {5});
  r.periodic(1, 100, 0, {6});
  EXPECT_EQ(r.run(20, 2), (Log{"0 start b0", "0 start c0", "2 start a0", "5 end b0", "6 end a0", "9 end c0"}));
  EXPECT_EQ(r.counters(1).preemptions, 0u);
  EXPECT_EQ(r.counters(2).preemptions, 1u);
}

TEST(ScheduleByHand, OnTwoCoresTheLeastUrgentRunningCycleLosesItsCore) {
  Rig r;
  r.periodic(5, 100, 3, {2});
  r.periodic(1, 100, 0, {10}).cpus = {0};
  r.periodic(2, 100, 0, {10}).cpus = {1};
  EXPECT_EQ(r.run(20, 2), (Log{"0 start c0", "0 start b0", "3 start a0", "5 end a0", "10 end c0", "12 end b0"}));
  EXPECT_EQ(r.counters(1).preemptions, 1u);
  EXPECT_EQ(r.counters(2).preemptions, 0u);
}

TEST(ScheduleByHand, OnTwoCoresAPinnedThreadWaitsThoughTheOtherCoreIsFree) {
  Rig r;
  r.periodic(2, 100, 0, {4}).cpus = {1};
  r.periodic(1, 100, 1, {2}).cpus = {1};
  EXPECT_EQ(r.run(20, 2), (Log{"0 start a0", "4 end a0", "4 start b0", "6 end b0"}));
  EXPECT_EQ(r.counters(1).preemptions, 0u);
}

TEST(ScheduleByHand, ADeviceTriggersWhenItIsReadyAndAPastInstantCountsAsNow) {
  Rig r;
  r.triggered(Trigger::device, 1, 0, {2});
  r.prepare();
  r.schedule->announce(0, Time{7});
  EXPECT_EQ(r.run(10), (Log{"7 start a0", "9 end a0"}));
  r.schedule->announce(0, Time{4});
  EXPECT_EQ(r.run(20), (Log{"7 start a0", "9 end a0", "10 start a0", "12 end a0"}));
  EXPECT_EQ(r.releases["a0@10"], 10);
}

TEST(ScheduleByHand, ARawTopicFilledAtTheStartOfAStepTriggersAtTheSameInstant) {
  Rig r;
  r.periodic(1, 100, 0, {4});
  r.triggered(Trigger::topics, 2, 0, {1});
  r.triggers_at_start["a0"] = 1;
  EXPECT_EQ(r.run(20), (Log{"0 start a0", "0 start b0", "1 end b0", "5 end a0"}));
  EXPECT_EQ(r.counters(0).preemptions, 1u);
}

TEST(ScheduleByHand, ATriggerBetweenTwoCallsActsAtTheInstantThatWasReached) {
  Rig r;
  r.triggered(Trigger::topics, 1, 0, {2});
  r.run(5);
  r.schedule->trigger(0);
  r.schedule->trigger(0);
  EXPECT_EQ(r.run(9), (Log{"5 start a0", "7 end a0"}));
  EXPECT_EQ(r.counters(0).coalesced, 1u);
}

TEST(ScheduleByHand, AStepTakesAtLeastOneNanosecond) {
  Rig r;
  r.periodic(1, 100, 0, {0, -5}).modules = 2;
  EXPECT_EQ(r.run(9), (Log{"0 start a0", "1 end a0", "1 start a1", "2 end a1"}));
}

TEST(ScheduleByHand, RunningInPiecesIsTheSameAsRunningAtOnce) {
  const auto run = [](std::int64_t piece) {
    Rig r;
    r.periodic(3, 7, 1, {2});
    r.periodic(1, 31, 0, {4, 9}).modules = 2;
    r.triggered(Trigger::topics, 2, 11, {3});
    r.triggers_at_end["b1"] = 2;
    for (std::int64_t t = 0; t <= 1000; t += piece) r.run(t);
    return r.run(1000);
  };
  EXPECT_EQ(run(1), run(1000));
  EXPECT_EQ(run(13), run(1000));
  EXPECT_GT(run(1000).size(), 300u);
}

}  // namespace
}  // namespace sinew::rt::schedule_hand_test
