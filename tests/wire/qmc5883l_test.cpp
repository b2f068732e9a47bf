#include "wire/qmc5883l.hpp"

#include <gtest/gtest.h>

namespace sinew::wire::qmc5883l::qmc5883l_test {
namespace {

TEST(Qmc5883l, SetUpWritesTheRegisterMapsBits) {
  const auto w = setup_writes({.range_gauss = 8, .rate_hz = 200});
  ASSERT_TRUE(w);
  EXPECT_EQ(w->back().address, kControl1);
  EXPECT_EQ(w->back().value, 0x1D) << "8 gauss, 200 Hz, continuous";
  EXPECT_EQ(setup_writes({.range_gauss = 2, .rate_hz = 10})->back().value, 0x01);
  EXPECT_FALSE(setup_writes({.range_gauss = 4}));
  EXPECT_FALSE(setup_writes({.rate_hz = 75}));
}

TEST(Qmc5883l, ABurstIsLittleEndianAndSaysWhetherItCounts) {
  const std::array<std::uint8_t, kBurst> b{0xB8, 0x0B, 0x48, 0xF4, 0x01, 0x00, kReady};
  const Sample s = decode_burst(b);
  EXPECT_EQ(s.field, (std::array<std::int16_t, 3>{3000, -3000, 1}));
  EXPECT_TRUE(s.ready);
  EXPECT_FALSE(s.overflow);
  EXPECT_DOUBLE_EQ(field_t(s, {.range_gauss = 8}).x, 1e-4) << "3000 counts are a gauss";
  EXPECT_DOUBLE_EQ(field_t(s, {.range_gauss = 2}).y, -0.25e-4);
  EXPECT_TRUE(decode_burst(std::array<std::uint8_t, kBurst>{0, 0, 0, 0, 0, 0, kOverflow}).overflow);
}

}  // namespace
}  // namespace sinew::wire::qmc5883l::qmc5883l_test
