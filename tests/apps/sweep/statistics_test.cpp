#include "apps/sweep/statistics.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <random>

namespace sinew::sweep::statistics_test {
namespace {

using ::testing::DoubleNear;

TEST(SweepStatistics, TheIntervalOfAShareIsWilsons) {
  // Source: R. G. Newcombe, Statistics in Medicine 17 (1998), table I: 81 of 263, 15 of 148, 0 of 20, 1 of 29.
  const auto is = [](std::uint64_t good, std::uint64_t all, double low, double high) {
    const Interval between = wilson_95(good, all);
    EXPECT_NEAR(between.low, low, 5e-5) << good << " of " << all;
    EXPECT_NEAR(between.high, high, 5e-5) << good << " of " << all;
  };
  is(81, 263, 0.2553, 0.3662);
  is(15, 148, 0.0624, 0.1605);
  is(0, 20, 0, 0.1611);
  is(1, 29, 0.0061, 0.1718);
}

TEST(SweepStatistics, NothingIsCertainWithoutRunsAndAllGoodRunsAllowForAllGood) {
  EXPECT_EQ(wilson_95(0, 0).low, 0);
  EXPECT_EQ(wilson_95(0, 0).high, 1);
  EXPECT_EQ(wilson_95(1000, 1000).high, 1);
  EXPECT_LT(wilson_95(1000, 1000).low, 1);
  EXPECT_EQ(wilson_95(0, 1000).low, 0);
}

TEST(SweepStatistics, TheTestOfPairsIsExactAndTwoSided) {
  EXPECT_EQ(mcnemar_p(0, 0), 1);
  EXPECT_EQ(mcnemar_p(7, 7), 1);
  EXPECT_NEAR(mcnemar_p(0, 5), 2 * 1.0 / 32, 1e-12);
  EXPECT_NEAR(mcnemar_p(5, 0), mcnemar_p(0, 5), 1e-15);
  EXPECT_NEAR(mcnemar_p(1, 9), 2 * (1 + 10) / 1024.0, 1e-12);
  EXPECT_THAT(mcnemar_p(400'000, 402'000), DoubleNear(0.0256, 0.0005)) << "neither overflow nor underflow";
}

TEST(SweepStatistics, QuantilesOfFewValuesAreExact) {
  Quantiles q;
  for (const double v : {3.0, 1.0, 2.0, 5.0}) q.add(v);
  EXPECT_EQ(q.at(0), 1);
  EXPECT_EQ(q.at(0.5), 2.5);
  EXPECT_EQ(q.at(1), 5);
  EXPECT_EQ(Quantiles().at(0.5), 0);
}

TEST(SweepStatistics, QuantilesOfManyValuesAreCloseWhateverTheirOrder) {
  std::vector<double> values;
  for (int i = -20'000; i <= 80'000; ++i) values.push_back(1e-3 * i);
  Quantiles sorted, shuffled;
  for (const double v : values) sorted.add(v);
  std::shuffle(values.begin(), values.end(), std::mt19937(1));
  for (const double v : values) shuffled.add(v);
  for (const double share : {0.0, 0.05, 0.5, 0.95, 1.0}) {
    const double exact = -20 + 100 * share;
    EXPECT_NEAR(sorted.at(share), exact, 0.003 * std::abs(exact) + 1e-3) << share;
    EXPECT_EQ(sorted.at(share), shuffled.at(share));
  }
  EXPECT_EQ(sorted.at(1), 80) << "never beyond the largest";
}

}  // namespace
}  // namespace sinew::sweep::statistics_test
