// How scans of the Industrial I/O are laid out and read.
#include "wire/iio.hpp"

#include <gtest/gtest.h>

#include "bytes.hpp"

namespace sinew::wire::iio_test {
namespace {

using test::Bytes;

IioForm form(const char* text) {
  const auto f = parse_iio_form(text);
  EXPECT_TRUE(f) << text;
  return f.value_or(IioForm{});
}

TEST(IioForm, IsReadAsTheKernelWritesIt) {
  const IioForm a = form("le:s16/16>>0\n");
  EXPECT_FALSE(a.big_endian);
  EXPECT_TRUE(a.is_signed);
  EXPECT_EQ(a.bits, 16);
  EXPECT_EQ(a.storage_bits, 16);
  EXPECT_EQ(a.shift, 0);
  EXPECT_EQ(a.repeat, 1);
  const IioForm b = form("be:u12/32X4>>4");
  EXPECT_TRUE(b.big_endian);
  EXPECT_FALSE(b.is_signed);
  EXPECT_EQ(b.bits, 12);
  EXPECT_EQ(b.storage_bits, 32);
  EXPECT_EQ(b.shift, 4);
  EXPECT_EQ(b.repeat, 4);
  EXPECT_EQ(b.bytes(), 16u);
}

TEST(IioForm, WhatCannotBeIsRefused) {
  for (const char* text : {"", "le", "le:", "le:s16", "le:s16/", "le:s16/24>>0", "le:s16/16>>1", "le:s0/16>>0",
                           "xe:s16/16>>0", "le:f16/16>>0", "le:s16/16>>0 x", "le:s65/64>>0", "le:s16/16X0>>0",
                           "le:s-1/16>>0", "le:s300/16>>0", "le:s16/16>>300"})
    EXPECT_FALSE(parse_iio_form(text)) << text;
}

TEST(IioLayout, SixAxesAndATimestampTakeTwentyFourBytes) {
  IioLayout layout;
  EXPECT_TRUE(layout.add(6, form("le:s64/64>>0")));  // order of adding does not matter, order of indexes does
  for (std::uint32_t i = 0; i < 6; ++i) EXPECT_TRUE(layout.add(i, form("be:s16/16>>0")));
  EXPECT_EQ(layout.scan_bytes(), 24u);
  EXPECT_EQ(layout.find(5)->offset, 10u);
  EXPECT_EQ(layout.find(6)->offset, 16u) << "aligned to its own size";
}

TEST(IioLayout, ThreeAxesOfThirtyTwoBitsArePaddedForTheTimestamp) {
  IioLayout layout;
  for (std::uint32_t i = 0; i < 3; ++i) ASSERT_TRUE(layout.add(i, form("le:s32/32>>0")));
  EXPECT_EQ(layout.scan_bytes(), 12u);
  ASSERT_TRUE(layout.add(3, form("le:s64/64>>0")));
  EXPECT_EQ(layout.scan_bytes(), 24u);
}

TEST(IioLayout, ARepeatedChannelIsAlignedToAllOfIt) {
  IioLayout layout;
  ASSERT_TRUE(layout.add(0, form("le:s8/8>>0")));
  ASSERT_TRUE(layout.add(1, form("le:s32/32X4>>0")));
  EXPECT_EQ(layout.find(1)->offset, 16u);
  EXPECT_EQ(layout.scan_bytes(), 32u);
}

TEST(IioLayout, AnIndexThatIsTakenChangesNothing) {
  IioLayout layout;
  ASSERT_TRUE(layout.add(0, form("le:s16/16>>0")));
  EXPECT_FALSE(layout.add(0, form("le:s32/32>>0")));
  EXPECT_EQ(layout.scan_bytes(), 2u);
  for (std::uint32_t i = 1; i < IioLayout::kMaxChannels; ++i) ASSERT_TRUE(layout.add(i, form("le:s16/16>>0")));
  EXPECT_FALSE(layout.add(99, form("le:s16/16>>0"))) << "full";
}

TEST(IioRaw, ReadsBothEndsShiftsMasksAndSigns) {
  const auto raw = [](const char* text, Bytes scan, std::size_t repeat = 0) {
    return iio_raw(scan, IioChannel{0, form(text), 0}, repeat);
  };
  EXPECT_EQ(raw("le:s16/16>>0", {0x34, 0x12}), 0x1234);
  EXPECT_EQ(raw("be:s16/16>>0", {0x12, 0x34}), 0x1234);
  EXPECT_EQ(raw("be:s16/16>>0", {0xFF, 0xFE}), -2);
  EXPECT_EQ(raw("be:u16/16>>0", {0xFF, 0xFE}), 65534);
  EXPECT_EQ(raw("le:s12/16>>4", {0xF7, 0xFF}), -1) << "the four lowest bits are another matter";
  EXPECT_EQ(raw("le:u12/16>>4", {0xF7, 0x80}), 0x80F);
  EXPECT_EQ(raw("le:s12/16>>0", {0x00, 0xF8}), -2048) << "bits above the twelve do not count";
  EXPECT_EQ(raw("le:s24/32>>8", {0x55, 0x00, 0x00, 0x80}), -8388608);
  EXPECT_EQ(raw("le:s64/64>>0", {1, 0, 0, 0, 0, 0, 0, 0x80}), INT64_MIN + 1);
  EXPECT_EQ(raw("be:s16/16X2>>0", {0, 1, 0, 2}, 1), 2);
}

TEST(IioRaw, AScanThatIsTooShortIsZeroAndNotRead) {
  EXPECT_EQ(iio_raw(Bytes{0xFF}, IioChannel{0, form("le:s16/16>>0"), 0}), 0);
  EXPECT_EQ(iio_raw(Bytes{1, 2}, IioChannel{0, form("le:s16/16>>0"), 0}, 1), 0) << "not repeated";
}

TEST(IioRaw, WhatIsPutIsReadAgain) {
  for (const char* text : {"le:s16/16>>0", "be:s12/16>>4", "le:s24/32>>8", "be:s64/64>>0", "le:s7/8>>1"})
    for (const std::int64_t value : {0, 1, -1, 63, -64}) {
      Bytes scan(8);
      const IioChannel channel{0, form(text), 0};
      put_iio_raw(scan, channel, value);
      EXPECT_EQ(iio_raw(scan, channel), value) << text;
    }
}

TEST(IioNumber, TakesWhatSysfsWrites) {
  EXPECT_EQ(parse_iio_number("0.000598550\n"), 0.000598550);
  EXPECT_EQ(parse_iio_number("-17"), -17);
  EXPECT_EQ(parse_iio_number("1e3"), 1000);
  for (const char* text : {"", "x", "1 2", "nan", "inf", "0x10", "1,5"}) EXPECT_FALSE(parse_iio_number(text)) << text;
}

TEST(IioMountMatrix, IsReadRowByRow) {
  const auto m = parse_iio_mount_matrix("0, 1, 0; -1, 0, 0; 0, 0, 1\n");
  ASSERT_TRUE(m);
  EXPECT_EQ(*m, (std::array<double, 9>{0, 1, 0, -1, 0, 0, 0, 0, 1}));
  for (const char* text :
       {"", "1, 0, 0", "1, 0, 0, 0, 1, 0, 0, 0, 1", "1, 0, 0; 0, 1, 0; 0, 0, x", "1, 0, 0; 0, 1, 0; 0, 0, 1; 2"})
    EXPECT_FALSE(parse_iio_mount_matrix(text)) << text;
}

}  // namespace
}  // namespace sinew::wire::iio_test
