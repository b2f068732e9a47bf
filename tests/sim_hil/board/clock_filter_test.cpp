// Two clocks, a network between them that delays as it likes, and whether the truth stays inside the bound.
#include "hal/clock_filter.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "sim_hil/board/plant_clock.hpp"

namespace sinew::sim_hil::clock_filter_test {
namespace {

using hal::ClockFilter;

using namespace std::chrono_literals;

/// Their clock as a function of ours, and one-way delays of each exchange.
struct World {
  double drift = 0;  // of the offset, ours minus theirs
  std::int64_t offset_ns = 0;
  std::function<std::int64_t(int)> there = [](int) { return 100'000; }, back = there;
  std::int64_t think_ns = 5'000;

  std::int64_t offset_at(std::int64_t ours) const {
    return offset_ns + static_cast<std::int64_t>(drift * static_cast<double>(ours));
  }
  Time theirs(std::int64_t ours) const { return Time{ours - offset_at(ours)}; }
  /// The i-th exchange, asked at `at` of ours.
  Time exchange(ClockFilter& filter, int i, std::int64_t at) const {
    const std::int64_t received = at + there(i), answered = received + think_ns, arrived = answered + back(i);
    EXPECT_TRUE(filter.add(Time{at}, theirs(received), theirs(answered), Time{arrived}));
    return Time{arrived};
  }
};

constexpr std::int64_t kPeriod = 200'000'000;

/// 40 s of exchanges; after each, and until the next, the truth must lie inside. The last estimate.
ClockFilter::Estimate follow(const World& world, ClockFilter& filter) {
  ClockFilter::Estimate e;
  for (int i = 0; i < 200; ++i) {
    const Time arrived = world.exchange(filter, i, 1'000'000'000 + i * kPeriod);
    for (const Duration later : {Duration{0}, Duration{50ms}, Duration{150ms}}) {
      const Time t = arrived + later;
      e = filter.at(t);
      const Duration miss = Duration{world.offset_at(t.ns)} - e.offset;
      EXPECT_LE(std::abs(miss.count()), e.bound.count()) << "exchange " << i << ", later by " << later.count();
    }
  }
  return e;
}

TEST(ClockFilter, EqualDelaysGiveTheOffsetAndHalfTheRoundTripBoundsIt) {
  World world;
  world.offset_ns = -7'000'000'000'123;
  ClockFilter filter;
  world.exchange(filter, 0, 1'000'000'000);
  const auto e = filter.at(Time{1'000'205'000});
  EXPECT_NEAR(static_cast<double>(e.offset.count()), static_cast<double>(world.offset_ns), 200);
  EXPECT_NEAR(static_cast<double>(e.bound.count()), 100'000, 300);
}

TEST(ClockFilter, LopsidedDelaysShiftTheEstimateButNeverBeyondTheBound) {
  World world;
  world.there = [](int) { return 100'000; };
  world.back = [](int) { return 4'900'000; };
  ClockFilter filter;
  const auto e = follow(world, filter);
  EXPECT_NEAR(static_cast<double>(e.offset.count()), 2'400'000, 60'000) << "half the difference, as it must";
  EXPECT_LT(e.bound, 2'600us);
  EXPECT_EQ(filter.restarts(), 0u);
}

TEST(ClockFilter, TruthLiesWithinTheBoundForEverySchedule) {
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    std::mt19937_64 random(seed);
    const auto up_to = [&](std::uint64_t n) { return static_cast<std::int64_t>(random() % (n + 1)); };
    World world;
    world.offset_ns = up_to(2'000'000'000'000) - 1'000'000'000'000;
    world.drift = (static_cast<double>(up_to(800)) - 400) * 1e-6;
    world.think_ns = up_to(300'000);
    const std::int64_t base_there = up_to(20'000'000), base_back = up_to(20'000'000);
    const std::uint64_t jitter = 1 + static_cast<std::uint64_t>(up_to(5'000'000));
    const auto delay = [&, jitter](std::int64_t base) {
      const bool outlier = random() % 10 == 0;  // a resent packet
      return base + up_to(jitter) + (outlier ? up_to(100'000'000) : 0);
    };
    world.there = [&, base_there](int) { return delay(base_there); };
    world.back = [&, base_back](int) { return delay(base_back); };
    ClockFilter filter;
    follow(world, filter);
    EXPECT_EQ(filter.restarts(), 0u) << "seed " << seed;
    EXPECT_EQ(filter.rejected(), 0u) << "seed " << seed;
    if (HasFailure()) FAIL() << "seed " << seed;
  }
}

TEST(ClockFilter, FastExchangesDecideAndSlowOnesDoNoHarm) {
  World world;
  world.there = [](int i) { return i % 10 == 0 ? 50'000 : 30'000'000; };
  world.back = [](int i) { return i % 10 == 5 ? 50'000 : 80'000'000; };  // never fast both ways at once
  ClockFilter filter;
  const auto e = follow(world, filter);
  EXPECT_LT(e.bound, 1ms) << "the fastest way there and the fastest way back need not be of one exchange";
}

TEST(ClockFilter, DriftIsFoundAndKeepsTheBoundTight) {
  World world;
  world.drift = 80e-6;
  std::mt19937_64 random(5);
  world.there = world.back = [&](int) { return 100'000 + static_cast<std::int64_t>(random() % 50'000); };
  ClockFilter filter;
  const auto e = follow(world, filter);
  EXPECT_NEAR(e.drift, 80e-6, 15e-6);
  EXPECT_LT(e.bound, 200us) << "0.2 s at the largest drift allowed would be as much again";
}

TEST(ClockFilter, ClockThatJumpsIsNoticedAndFollowed) {
  World world;
  ClockFilter filter;
  for (int i = 0; i < 50; ++i) world.exchange(filter, i, 1'000'000'000 + i * kPeriod);
  world.offset_ns = 30'000'000;
  const Time t = world.exchange(filter, 50, 1'000'000'000 + 50 * kPeriod);
  EXPECT_EQ(filter.restarts(), 1u);
  EXPECT_LE(std::abs((Duration{30ms} - filter.at(t).offset).count()), filter.at(t).bound.count());
}

TEST(ClockFilter, StampsThatNoExchangeCanHaveAreRejected) {
  ClockFilter filter;
  EXPECT_FALSE(filter.add(Time{100}, Time{5}, Time{6}, Time{99})) << "arrived before it was asked";
  EXPECT_FALSE(filter.add(Time{100}, Time{6}, Time{5}, Time{200})) << "answered before it was received";
  EXPECT_FALSE(filter.add(Time{100}, Time{5}, Time{500}, Time{200})) << "took longer there than here";
  EXPECT_FALSE(filter.any());
  EXPECT_TRUE(filter.add(Time{100}, Time{5}, Time{6}, Time{200}));
  EXPECT_FALSE(filter.add(Time{50}, Time{5}, Time{6}, Time{150})) << "before the last one";
  EXPECT_EQ(filter.rejected(), 4u);
}

TEST(ClockFilter, BoundGrowsWhileNobodyAnswers) {
  ClockFilter filter;
  World().exchange(filter, 0, 1'000'000'000);
  const Time t{1'000'205'000};
  EXPECT_NEAR(static_cast<double>((filter.at(t + 10s).bound - filter.at(t).bound).count()), 5e6, 1e3) << "500 ppm";
}

TEST(PlantClock, StandsAtOnceWhereItIsSet) {
  PlantClock clock;
  clock.set(5s);
  EXPECT_EQ(clock.map(Time{7}), Time{7} + 5s);
  EXPECT_EQ(clock.lag(), 0s);
}

TEST(PlantClock, CorrectionChangesNoPeriodByMoreThanTheSlewLimit) {
  PlantClock clock;
  clock.set(1s);
  Time last = clock.map(Time{} + 1s);
  Duration total{0};
  for (int i = 1; i <= 10'000; ++i) {
    if (i == 10) clock.steer(1s + 2ms);
    if (i == 6'001) clock.steer(1s - 1ms);
    const Time stamp = clock.map(Time{} + 1s + i * 1ms);
    const Duration dt = stamp - last;
    EXPECT_LE(std::abs((dt - Duration{1ms}).count()), 500) << i;
    total += dt - Duration{1ms};
    last = stamp;
  }
  EXPECT_EQ(clock.offset(), 1s + 2ms - 2ms + 0ns) << "4 s at 500 ppm towards the last target";
  EXPECT_EQ(total, 0ms);
  EXPECT_EQ(clock.lag(), 1ms);
}

TEST(PlantClock, OlderStampOfASlowerDeviceMovesNothing) {
  PlantClock clock;
  clock.set(1s);
  clock.map(Time{} + 1s);
  clock.steer(2s);
  EXPECT_EQ(clock.map(Time{} + 900ms), Time{} + 1900ms);
  EXPECT_EQ(clock.offset(), 1s);
}

}  // namespace
}  // namespace sinew::sim_hil::clock_filter_test
