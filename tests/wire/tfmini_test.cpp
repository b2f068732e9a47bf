#include "wire/tfmini.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "bytes.hpp"

namespace sinew::wire::tfmini_test {
namespace {

using test::Bytes, test::frames_in, test::joined;

const Bytes kOneMetre{0x59, 0x59, 0x64, 0x00, 0xE8, 0x03, 0x00, 0x00, 0x01};  // 100 cm, strength 1000

TEST(TfMini, AFrameIsDistanceAndStrength) {
  TfMiniScanner scanner;
  const auto frames = frames_in(scanner, kOneMetre);
  ASSERT_EQ(frames.size(), 1u);
  const TfMiniReading r = decode_tfmini(frames[0]);
  EXPECT_DOUBLE_EQ(r.range_m, 1.0);
  EXPECT_EQ(r.strength, 1000);
}

TEST(TfMini, NoEchoWeakOrBlindedIsNotANumber) {
  for (const auto& [cm, strength] : std::vector<std::pair<int, int>>{
           {0, 1000}, {65535, 50}, {65534, 1000}, {65532, 1000}, {120, 99}, {120, 65535}}) {
    const auto f = encode_tfmini(static_cast<std::uint16_t>(cm), static_cast<std::uint16_t>(strength));
    EXPECT_TRUE(std::isnan(decode_tfmini(f).range_m)) << cm << " " << strength;
  }
  EXPECT_DOUBLE_EQ(decode_tfmini(encode_tfmini(120, 30), 20).range_m, 1.2) << "the first model trusts weaker echos";
}

TEST(TfMini, AFrameBehindABrokenOneIsFound) {
  Bytes broken = kOneMetre;
  broken[2] ^= 1;
  TfMiniScanner scanner;
  EXPECT_EQ(frames_in(scanner, joined({broken, kOneMetre})), std::vector<Bytes>{kOneMetre});
  EXPECT_EQ(scanner.stats().broken, 1u);
  EXPECT_EQ(scanner.stats().skipped_bytes, 9u);
}

TEST(TfMini, AStreamThatIsCutAnywhereGoesOnWithTheNextFrame) {
  for (std::size_t cut = 1; cut < kOneMetre.size(); ++cut) {
    TfMiniScanner scanner;
    const Bytes rest(kOneMetre.begin() + static_cast<std::ptrdiff_t>(cut), kOneMetre.end());
    const auto frames = frames_in(scanner, joined({rest, kOneMetre, kOneMetre}));
    ASSERT_EQ(frames.size(), 2u) << cut;
    EXPECT_EQ(frames[1], kOneMetre);
  }
}

TEST(TfMini, AHeadThatRepeatsItselfDoesNotHideTheFrame) {
  TfMiniScanner scanner;
  EXPECT_EQ(frames_in(scanner, joined({{0x59}, kOneMetre})), std::vector<Bytes>{kOneMetre});
}

}  // namespace
}  // namespace sinew::wire::tfmini_test
