// Stamps of samples that a chip takes by a clock of its own; and how chips sit in the robot.
#include "drivers/sample_clock.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "drivers/mount.hpp"

namespace sinew::drivers::sample_clock_test {
namespace {

using namespace std::chrono_literals;

/// A chip whose clock is off by `ppm`, read each `poll` with a jitter; the largest error of stamps after a second.
struct Outcome {
  hal::Duration worst{};
  double step_spread = 0;  // of the steps after that second, in parts of the period
  bool rises = true, none_late = true;
};

Outcome run(double off, hal::Duration poll, hal::Duration jitter) {
  const double period = 1e6 * (1 + off);  // ns
  SampleClock clock(1ms);
  Outcome out;
  std::uint32_t random = 12345;
  std::int64_t taken = 0;
  hal::Time last{INT64_MIN};
  for (hal::Time now{1'000'000'000}; now < hal::Time{6'000'000'000}; now = now + poll) {
    random = random * 1664525 + 1013904223;
    const hal::Time at = now + jitter * (random >> 16) / 65536;
    const auto there = static_cast<std::int64_t>(std::floor(static_cast<double>(at.ns - 1'000'000'000) / period)) + 1;
    if (there <= taken) continue;
    const auto stamps = clock.found(static_cast<std::size_t>(there - taken), at);
    for (std::int64_t i = taken; i < there; ++i) {
      const hal::Time stamp = stamps.at(static_cast<std::size_t>(i - taken));
      const auto truth = static_cast<std::int64_t>(1e9 + static_cast<double>(i) * period);
      out.rises = out.rises && stamp > last;
      out.none_late = out.none_late && stamp <= at;
      if (at.ns > 2'000'000'000) {
        out.worst = std::max(out.worst, hal::Duration{std::abs(stamp.ns - truth)});
        out.step_spread = std::max(out.step_spread, std::abs(static_cast<double>((stamp - last).count()) / period - 1));
      }
      last = stamp;
    }
    taken = there;
  }
  return out;
}

TEST(SampleClock, FollowsAChipThatIsOffByTwoPercent) {
  for (const double off : {-0.02, -0.001, 0.0, 0.02}) {
    const Outcome o = run(off, 1ms, 300us);
    EXPECT_TRUE(o.rises) << off;
    EXPECT_TRUE(o.none_late) << off;
    EXPECT_LT(o.worst, 1ms) << off;
    EXPECT_LT(o.step_spread, 0.25) << off << ": smoother than the looks, which jump by a whole period";
  }
}

TEST(SampleClock, ManySamplesAtOnceAreSpreadEvenly) {
  const Outcome o = run(0.01, 10ms, 1ms);
  EXPECT_TRUE(o.rises);
  EXPECT_TRUE(o.none_late);
  EXPECT_LT(o.worst, 2ms);
}

TEST(SampleClock, AfterAGapStampsAreNewAndStillRise) {
  SampleClock clock(1ms);
  const auto a = clock.found(1, hal::Time{1'000'000'000}).first;
  const auto b = clock.found(1, hal::Time{2'000'000'000}).first;
  EXPECT_GT(b, a);
  EXPECT_GE(b, hal::Time{1'998'000'000});
  clock.restart();
  EXPECT_GE(clock.found(1, hal::Time{3'000'000'000}).first, hal::Time{2'998'000'000});
}

TEST(Mount, QuarterTurnsAreExactAndNamedAfterTheAxes) {
  EXPECT_EQ(Mount({.yaw_deg = 90}).to_base({1, 0, 0}), (msg::Vec3{0, 1, 0}));
  EXPECT_EQ(Mount({.roll_deg = 180}).to_base({1, 2, 3}), (msg::Vec3{1, -2, -3}));
  EXPECT_EQ(Mount({.pitch_deg = 90}).to_base({1, 0, 0}), (msg::Vec3{0, 0, -1}));
  EXPECT_EQ(Mount({.yaw_deg = -270}).to_base({1, 0, 0}), (msg::Vec3{0, 1, 0}));
  const msg::Vec3 v = Mount({.roll_deg = 10, .pitch_deg = 20, .yaw_deg = 30}).to_base({1, 2, 3});
  EXPECT_NEAR(v.x * v.x + v.y * v.y + v.z * v.z, 14, 1e-12) << "a rotation";
}

}  // namespace
}  // namespace sinew::drivers::sample_clock_test
