#include "apps/search/shrink.hpp"

#include <gtest/gtest.h>

#include "apps/search/generate.hpp"

namespace sinew::search::shrink_test {
namespace {

using namespace std::chrono_literals;

using Fails = std::function<bool(const Case&)>;

FirstFailing by(const Fails& fails, std::size_t* runs = nullptr) {
  return [=](const std::vector<Case>& cases) -> std::optional<std::size_t> {
    for (std::size_t i = 0; i < cases.size(); ++i) {
      if (runs) ++*runs;
      if (fails(cases[i])) return i;
    }
    return std::nullopt;
  };
}

Case parsed(std::string_view text) {
  std::string why;
  const auto c = parse_case(text, why);
  EXPECT_TRUE(c) << why;
  return c.value_or(Case{});
}

TEST(Shrink, OnlyWhatIsNeededStays) {
  const Case c = parsed(
      "world=123456 jitter=98765 gust=1.7 stress=pad*3 stress=imu*2 fault=range:off@3.217+0.3 "
      "fault=imu:off@7.531+0.064 fault=camera:delayed(60ms)@2.5+1 fault=baro:off@9+1");
  const auto needs_a_long_imu_gap = [](const Case& x) {
    for (const Fault& f : x.faults)
      if (f.device == "imu" && f.length >= 13ms && f.from >= Time{5'500'000'000}) return true;
    return false;
  };
  EXPECT_EQ(to_string(shrink(c, by(needs_a_long_imu_gap))), "world=1 jitter=none fault=imu:off@7+0.016");
}

TEST(Shrink, TwoFaultsThatFailOnlyTogetherBothStay) {
  const Case c = parsed("fault=range:off@3+1 fault=imu:off@7+0.01 fault=camera:off@2+1 fault=baro:off@9+1");
  const auto needs_both = [](const Case& x) {
    bool range = false, baro = false;
    for (const Fault& f : x.faults) range |= f.device == "range", baro |= f.device == "baro";
    return range && baro;
  };
  const Case small = shrink(c, by(needs_both));
  ASSERT_EQ(small.faults.size(), 2u);
  EXPECT_EQ(small.faults[0].device, "range");
  EXPECT_EQ(small.faults[1].device, "baro");
}

TEST(Shrink, StressGoesDownTowardsNominalWhileItFails) {
  const Case c = parsed("jitter=7 stress=filter*4");
  const Case small = shrink(c, by([](const Case& x) { return x.stress_of("filter") >= 2.1; }));
  EXPECT_EQ(to_string(small), "world=1 jitter=1 stress=filter*2.1");
}

TEST(Shrink, EndsForEveryCaseAlsoWhenEverythingFails) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    std::size_t runs = 0;
    const Case small = shrink(generate(seed, {"imu", "pad"}), by([](const Case&) { return true; }, &runs));
    EXPECT_EQ(to_string(small), "world=1 jitter=none");
    EXPECT_LT(runs, 40u);
  }
}

TEST(Shrink, WhatFailsNoLongerWhenItIsSimplerStaysAsItIs) {
  const Case c = generate(11, {"imu"});
  EXPECT_EQ(shrink(c, by([](const Case&) { return false; })), c);
}

}  // namespace
}  // namespace sinew::search::shrink_test
