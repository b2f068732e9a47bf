#include "record/run/step_counts.hpp"

#include <gmock/gmock.h>

namespace sinew::record::step_counts_test {
namespace {

using namespace std::chrono_literals;
using Kind = rt::TimelineEvent::Kind;

/// A step of module 0 or 1 of a thread that is released at `release_us` and begins 5 us later.
LoggedStep step_of(std::uint32_t module, std::int64_t release_us, rt::StepStatus status = rt::StepStatus::ok) {
  LoggedStep step;
  step.module = module;
  step.release = rt::Time{release_us * 1000};
  step.now = step.release + 5us + module * 20us;
  step.completed = step.now + 20us;
  step.exec = 15us;
  step.status = status;
  return step;
}

std::vector<LoggedStep> cycles(std::int64_t from_us, int count) {
  std::vector<LoggedStep> steps;
  for (int i = 0; i < count; ++i) {
    steps.push_back(step_of(0, from_us + 1000 * i));
    steps.push_back(step_of(1, from_us + 1000 * i, i % 2 ? rt::StepStatus::stale : rt::StepStatus::ok));
  }
  return steps;
}

TEST(StepCounts, CountsCyclesAndStepsAsTheRobotDid) {
  StepCounts counts(1, 2);
  counts.add(cycles(0, 4));
  EXPECT_EQ(counts.thread(0).releases.value(), 4u);
  EXPECT_EQ(counts.thread(0).completions.value(), 3u) << "the fourth may go on in the next batch";
  EXPECT_EQ(counts.thread(0).lateness.max(), 5us);
  EXPECT_EQ(counts.thread(0).exec.max(), 40us) << "first start to last end";
  EXPECT_EQ(counts.module(0).ok.value(), 4u);
  EXPECT_EQ(counts.module(1).stale.value(), 2u);
  EXPECT_EQ(counts.module(1).exec.max(), 15us);
}

TEST(StepCounts, TheTimeLineHasEachEventOnceThoughTheTimeWentBack) {
  StepCounts counts(1, 2);
  counts.add(cycles(0, 4));
  counts.add(cycles(2000, 2));
  std::vector<std::int64_t> steps_us;
  for (const auto& e : counts.timeline(rt::Time{1'000'000'000}, 1s))
    if (e.kind == Kind::step && e.module == 0) steps_us.push_back(e.at.ns / 1000);
  EXPECT_THAT(steps_us, testing::ElementsAre(5, 1005, 2005, 3005));
}

TEST(StepCounts, TheTimeLineEndsAtTheInstantThatIsAskedFor) {
  StepCounts counts(1, 2);
  counts.add(cycles(0, 10));
  const auto events = counts.timeline(rt::Time{4'500'000}, 2ms);
  ASSERT_FALSE(events.empty());
  EXPECT_GE(events.front().at, rt::Time{2'500'000});
  EXPECT_LE(events.back().at, rt::Time{4'500'000});
}

TEST(StepCounts, StepsOfThreadsAndModulesThatThereAreNotAreLeftOut) {
  StepCounts counts(1, 2);
  std::vector<LoggedStep> steps{step_of(7, 0)};
  steps.push_back(step_of(0, 0));
  steps.back().thread = 0xFFFFFFFF;
  counts.add(steps);
  EXPECT_EQ(counts.thread(0).releases.value(), 0u);
  EXPECT_TRUE(counts.timeline(rt::Time{INT64_MAX}, 1s).empty());
}

}  // namespace
}  // namespace sinew::record::step_counts_test
