#include "math/hash.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "math/random.hpp"

namespace {

using sinew::math::fnv1a64;
using sinew::math::Hash64;
using sinew::math::hash64;
using sinew::math::Random;

TEST(Fnv1a, GivesThePublishedValues) {
  static_assert(fnv1a64("") == 0xcbf29ce484222325);
  static_assert(fnv1a64("a") == 0xaf63dc4c8601ec8c);
  static_assert(fnv1a64("foobar") == 0x85944171f73967e8);
  EXPECT_EQ(fnv1a64("bar", fnv1a64("foo")), fnv1a64("foobar"));
}

TEST(Hash64, GivesThePublishedValues) {
  const auto of = [](const std::string& s) { return hash64(s.data(), s.size()); };
  EXPECT_EQ(of(""), 0xef46db3751d8e999u);
  EXPECT_EQ(of("a"), 0xd24ec4f1a98c6e5bu);
  EXPECT_EQ(of("abc"), 0x44bc2cf5ad770999u);
}

TEST(Hash64, PiecesOfAnySizeGiveTheValueOfTheWhole) {
  Random random(3);
  std::vector<std::uint8_t> bytes(5000);
  for (auto& b : bytes) b = static_cast<std::uint8_t>(random.next_u32());
  for (int round = 0; round < 200; ++round) {
    const std::size_t n = random.below(5001);
    Hash64 h(9);
    for (std::size_t at = 0; at < n;) {
      const std::size_t piece = std::min<std::size_t>(random.below(round % 2 == 0 ? 9 : 200), n - at);
      h.add(bytes.data() + at, piece);
      at += piece;
      if (round % 7 == 0) static_cast<void>(h.value());  // looking does not disturb
    }
    ASSERT_EQ(h.value(), hash64(bytes.data(), n, 9)) << n;
  }
}

TEST(Hash64, EveryBitOfInputLengthAndSeedCounts) {
  std::vector<std::uint8_t> bytes(100);
  const std::uint64_t whole = hash64(bytes.data(), bytes.size());
  for (std::size_t bit = 0; bit < 800; ++bit) {
    bytes[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
    EXPECT_NE(hash64(bytes.data(), bytes.size()), whole) << bit;
    bytes[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
  }
  EXPECT_NE(hash64(bytes.data(), 99), whole);
  EXPECT_NE(hash64(bytes.data(), 100, 1), whole);
}

}  // namespace
