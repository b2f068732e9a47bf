#include "rt/exec/stats.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "math/random.hpp"

namespace sinew::rt::stats_test {
namespace {

TEST(Histogram, EmptyAnswersZero) {
  const Histogram h;
  EXPECT_EQ(h.count(), 0u);
  EXPECT_EQ(h.quantile(0.5), Duration{0});
  EXPECT_EQ(h.min(), Duration{0});
  EXPECT_EQ(h.mean_ns(), 0.0);
}

TEST(Histogram, SmallValuesAreExact) {
  Histogram h;
  for (int i = 1; i <= 10; ++i) h.add(Duration{i});
  EXPECT_EQ(h.quantile(0.5), Duration{5});
  EXPECT_EQ(h.quantile(0.51), Duration{6});
  EXPECT_EQ(h.quantile(0.0), Duration{1});
  EXPECT_EQ(h.quantile(1.0), Duration{10});
  EXPECT_EQ(h.mean_ns(), 5.5);
}

TEST(Histogram, QuantilesAreAtMostASixteenthAboveThoseOfTheSortedData) {
  math::Random random(1, 2, 3);
  for (int round = 0; round < 200; ++round) {
    Histogram h;
    std::vector<std::int64_t> values;
    const std::uint32_t bits = 1 + random.below(40), n = 1 + random.below(500);
    for (std::uint32_t i = 0; i < n; ++i) {
      values.push_back(static_cast<std::int64_t>(random.next_u64() >> (64 - bits)));
      h.add(Duration{values.back()});
    }
    std::sort(values.begin(), values.end());
    for (const double q : {0.0, 0.01, 0.25, 0.5, 0.9, 0.99, 0.999, 1.0}) {
      std::size_t rank = 1;  // smallest rank with rank / n >= q
      while (static_cast<double>(rank) < q * n) ++rank;
      const std::int64_t truth = values[rank - 1], got = h.quantile(q).count();
      EXPECT_GE(got, truth) << "q " << q;
      EXPECT_LE(got - truth, truth / 16) << "q " << q;
    }
    EXPECT_EQ(h.min().count(), values.front());
    EXPECT_EQ(h.max().count(), values.back());
    EXPECT_EQ(h.count(), n);
  }
}

TEST(Histogram, NegativeCountsAsZeroAndTheLongestAsTheMaximum) {
  Histogram h;
  h.add(Duration{-5});
  h.add(Duration{INT64_MAX / 4});
  EXPECT_EQ(h.quantile(0.5), Duration{0});
  EXPECT_EQ(h.quantile(1.0), Duration{INT64_MAX / 4});
}

}  // namespace
}  // namespace sinew::rt::stats_test
