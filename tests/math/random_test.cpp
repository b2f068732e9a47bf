#include "math/random.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace {

using namespace sinew;
using math::philox4x32;
using math::Random;

TEST(Philox, GivesTheKnownAnswersOfItsAuthors) {
  // Random123 1.09, tests/kat_vectors, philox4x32 with 10 rounds.
  using Words = std::array<std::uint32_t, 4>;
  EXPECT_EQ(philox4x32({0, 0, 0, 0}, {0, 0}), (Words{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  constexpr std::uint32_t f = 0xffffffff;
  EXPECT_EQ(philox4x32({f, f, f, f}, {f, f}), (Words{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  EXPECT_EQ(philox4x32({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
            (Words{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

std::vector<std::uint32_t> words(Random random) {
  std::vector<std::uint32_t> w(10);
  for (auto& x : w) x = random.next_u32();
  return w;
}

TEST(Random, IsAFunctionOfSeedStreamAndCounter) {
  EXPECT_EQ(words(Random(1, 2, 3)), words(Random(1, 2, 3)));
  EXPECT_NE(words(Random(1, 2, 3)), words(Random(2, 2, 3)));
  EXPECT_NE(words(Random(1, 2, 3)), words(Random(1ull << 40 | 1, 2, 3)));
  EXPECT_NE(words(Random(1, 2, 3)), words(Random(1, 3, 3)));
  EXPECT_NE(words(Random(1, 2, 3)), words(Random(1, 2, 4)));
  EXPECT_NE(words(Random(1, 2, 3)), words(Random(1, 2, 1ull << 40 | 3)));
}

TEST(Random, NeighbouringStepsAreUncorrelated) {
  double sum = 0, product = 0;
  constexpr int n = 100000;
  double last = 0.5;
  for (int i = 0; i < n; ++i) {
    Random step(7, 1, static_cast<std::uint64_t>(i));
    const double u = step.uniform();
    sum += u, product += (u - 0.5) * (last - 0.5);
    last = u;
  }
  EXPECT_NEAR(sum / n, 0.5, 5 * 0.2887 / std::sqrt(n));  // 5 sigma
  EXPECT_NEAR(product / n, 0, 5 * (1.0 / 12) / std::sqrt(n));
}

TEST(Random, UniformIsFlatAndStaysInItsRange) {
  Random random(11);
  std::vector<int> bins(64);
  constexpr int n = 640000;
  for (int i = 0; i < n; ++i) {
    const double u = random.uniform();
    ASSERT_GE(u, 0);
    ASSERT_LT(u, 1);
    ++bins[static_cast<std::size_t>(u * 64)];
  }
  double chi2 = 0;
  for (const int b : bins) chi2 += (b - 1e4) * (b - 1e4) / 1e4;
  EXPECT_LT(chi2, 63 + 5 * std::sqrt(2 * 63.0));
  for (int i = 0; i < 1000; ++i) {
    const double u = random.uniform(-3, -1);
    ASSERT_TRUE(u >= -3 && u <= -1);
  }
}

TEST(Random, NormalHasTheMomentsAndTailsOfANormal) {
  Random random(13);
  constexpr int n = 1000000;
  double s1 = 0, s2 = 0, s3 = 0, s4 = 0, pairs = 0, last = 0;
  int beyond2 = 0, beyond4 = 0;
  for (int i = 0; i < n; ++i) {
    const double x = random.normal();
    ASSERT_TRUE(std::isfinite(x));
    s1 += x, s2 += x * x, s3 += x * x * x, s4 += x * x * x * x, pairs += x * last;
    beyond2 += std::fabs(x) > 2, beyond4 += std::fabs(x) > 4;
    last = x;
  }
  const double root = std::sqrt(n);
  EXPECT_NEAR(s1 / n, 0, 5 / root);
  EXPECT_NEAR(s2 / n, 1, 5 * std::sqrt(2.0) / root);
  EXPECT_NEAR(s3 / n, 0, 5 * std::sqrt(15.0) / root);
  EXPECT_NEAR(s4 / n, 3, 5 * std::sqrt(96.0) / root);
  EXPECT_NEAR(pairs / n, 0, 5 / root);
  EXPECT_NEAR(beyond2 / static_cast<double>(n), 0.0455, 5 * 0.209 / root);
  EXPECT_GT(beyond4, 20);  // 63 expected
  EXPECT_LT(beyond4, 120);
}

TEST(Random, BelowIsFlatAndNeverReachesItsBound) {
  Random random(17);
  std::array<int, 7> bins{};
  constexpr int n = 70000;
  for (int i = 0; i < n; ++i) {
    const std::uint32_t v = random.below(7);
    ASSERT_LT(v, 7U);
    ++bins[v];
  }
  for (const int b : bins) EXPECT_NEAR(b, n / 7, 5 * std::sqrt(n / 7.0));
  EXPECT_EQ(random.below(1), 0U);
  EXPECT_EQ(random.below(0), 0U);
}

}  // namespace
