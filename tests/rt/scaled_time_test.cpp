// The real-time executor on a clock at another pace: releases count in that clock's time.
#include <gtest/gtest.h>

#include "graph_fixture.hpp"
#include "hal/platform.hpp"
#include "hal/scaled_os.hpp"
#include "rt/exec/real_time_executor.hpp"
#include "test_modules.hpp"
#include "until.hpp"

namespace sinew::rt::scaled_time_test {
namespace {

class Pace : public ::testing::TestWithParam<double> {};

TEST_P(Pace, ReleasesAreDueOnTheScaledClockAndNoneComesBefore) {
  constexpr Duration kPeriod = 2ms;
  hal::ScaledOs os(hal::system_os(), GetParam());
  Robot robot;
  robot.virtual_time = false;
  robot.add<Numbers>("numbers");
  robot.periodic("main", 0, kPeriod, {"numbers"});
  RealTimeOptions options;
  options.start_delay = 1ms;
  RealTimeExecutor executor(robot.build(), os, options);
  ASSERT_TRUE(executor.start());
  const ThreadStats& stats = executor.runner().thread_stats(0);
  until([&] { return stats.completions.value() >= 50; });
  const std::uint64_t due_by_now = stats.releases.value() + stats.skips.value();
  const Time before = os.now();
  executor.stop();
  const Time after = os.now();
  const Time start = executor.started_at();
  ASSERT_GE(stats.completions.value(), 50u);
  EXPECT_LE(static_cast<std::int64_t>(due_by_now), (before - start) / kPeriod + 1) << "a release came too early";
  // Whatever was due has run or is counted as skipped, but for a release that stop() met in its sleep.
  EXPECT_LE(static_cast<std::int64_t>(stats.releases.value() + stats.skips.value()), (after - start) / kPeriod + 1);
}

INSTANTIATE_TEST_SUITE_P(Rates, Pace, testing::Values(0.25, 1.0, 3.0));

}  // namespace
}  // namespace sinew::rt::scaled_time_test
