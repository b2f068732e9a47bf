#include "msg/cdr.hpp"

#include <gtest/gtest.h>

#include <string>

#include "msg/compare.hpp"
#include "msg/geometry.hpp"
#include "msg/image.hpp"
#include "msg/sensors.hpp"
#include "random_message.hpp"

namespace {

using namespace sinew;
using test::kBulkCapacity;
using test::random_message;
using test::Slot;

std::vector<std::uint8_t> encoded(const msg::TypeInfo& type, const void* message) {
  std::vector<std::uint8_t> bytes(msg::cdr_size(type, message));
  EXPECT_EQ(msg::cdr_encode(type, message, bytes), bytes.size());
  return bytes;
}

std::uint32_t capacity_of(const msg::TypeInfo& type) { return type.has_bulk() ? kBulkCapacity : 0; }

TEST(Cdr, EveryTypeRoundTripsByteEqual) {
  math::Random random(3);
  for (const msg::TypeInfo* type : msg::all_types())
    for (int i = 0; i < 300; ++i) {
      const Slot sent = random_message(*type, random);
      const auto bytes = encoded(*type, sent.get());
      Slot received(*type);
      const auto result = msg::cdr_decode(*type, bytes, received.get(), capacity_of(*type));
      ASSERT_TRUE(result) << type->name << ": " << result.error << " " << result.field;
      ASSERT_TRUE(msg::equal(*type, sent.get(), received.get())) << type->name;
      ASSERT_EQ(encoded(*type, received.get()), bytes) << type->name;
    }
}

TEST(Cdr, BytesOfARangeSampleAreThoseOfTheStandard) {
  msg::RangeSample m;
  m.stamp.ns = 0x0102030405060708;
  m.range_m = 1.0;
  const std::vector<std::uint8_t> want{0, 1, 0, 0, 8, 7, 6, 5, 4, 3, 2, 1, 0, 0, 0, 0, 0, 0, 0xf0, 0x3f};
  EXPECT_EQ(encoded(msg::type_info<msg::RangeSample>(), &m), want);
}

// Sizes up and down, without padding.
struct Inner {
  std::uint32_t number = 0;
};
struct Outer {
  std::array<std::uint16_t, 2> pair{};
  Inner inner;
  double value = 0;
  std::array<std::uint8_t, 3> three{};
  std::uint8_t last = 0;
  std::int32_t tail = 0;
};

}  // namespace

template <>
struct sinew::msg::Description<Inner> {
  static constexpr std::string_view name = "Inner", doc = "Nested.";
  static constexpr auto fields = describe(field<&Inner::number>("1"));
};
template <>
struct sinew::msg::Description<Outer> {
  static constexpr std::string_view name = "Outer", doc = "Mixed sizes.";
  static constexpr auto fields =
      describe(field<&Outer::pair>("1"), field<&Outer::inner>("1"), field<&Outer::value>("1"),
               field<&Outer::three>("1"), field<&Outer::last>("1"), field<&Outer::tail>("1"));
};

namespace {

TEST(Cdr, MixedSizesAreAlignedFromBehindTheHeader) {
  Outer m{{1, 2}, {3}, 0.5, {4, 5, 6}, 7, -1};
  const std::vector<std::uint8_t> want{0, 1, 0, 0, 1,    0,    2, 0, 3, 0, 0,    0,    0,    0,
                                       0, 0, 0, 0, 0xe0, 0x3f, 4, 5, 6, 7, 0xff, 0xff, 0xff, 0xff};
  EXPECT_EQ(encoded(msg::type_info<Outer>(), &m), want);
}

TEST(Cdr, BulkIsASequenceBehindTheFields) {
  const msg::TypeInfo& type = msg::type_info<msg::Image>();
  Slot slot(type);
  auto& image = *static_cast<msg::Image*>(slot.get());
  ASSERT_TRUE(image.format_as(msg::PixelFormat::mono8, 3, 1));
  image.pixels()[0] = 10, image.pixels()[1] = 11, image.pixels()[2] = 12;
  const auto bytes = encoded(type, &image);
  ASSERT_EQ(bytes.size(), 4 + sizeof(msg::Image) + 4 + 3);
  const std::vector<std::uint8_t> tail(bytes.end() - 7, bytes.end());
  EXPECT_EQ(tail, (std::vector<std::uint8_t>{3, 0, 0, 0, 10, 11, 12}));
}

TEST(Cdr, EveryShorterInputAndEveryShorterBufferIsRefused) {
  math::Random random(4);
  for (const msg::TypeInfo* type : msg::all_types()) {
    Slot sent(*type);
    if (type->has_bulk()) {
      ASSERT_TRUE(static_cast<msg::Image*>(sent.get())->format_as(msg::PixelFormat::rgb8, 5, 4));
    }
    const auto bytes = encoded(*type, sent.get());
    for (std::size_t n = 0; n < bytes.size(); ++n) {
      Slot received = random_message(*type, random);
      const auto result = msg::cdr_decode(*type, std::span(bytes).first(n), received.get(), capacity_of(*type));
      ASSERT_FALSE(result) << type->name << " " << n;
      ASSERT_NE(std::string(result.error), "");
      Slot fresh(*type);
      ASSERT_TRUE(msg::equal(*type, received.get(), fresh.get())) << type->name << ": not at its defaults";
      std::vector<std::uint8_t> small(n);
      ASSERT_EQ(msg::cdr_encode(*type, sent.get(), small), 0U) << type->name << " " << n;
    }
  }
}

TEST(Cdr, WhatIsWrongIsSaidWithFieldAndPlace) {
  const msg::TypeInfo& type = msg::type_info<msg::ImuSample>();
  msg::ImuSample m;
  auto bytes = encoded(type, &m);
  msg::ImuSample out;

  auto result = msg::cdr_decode(type, std::span(bytes).first(30), &out);
  EXPECT_STREQ(result.error, "input ends inside the message");
  EXPECT_EQ(result.field, "z");
  EXPECT_EQ(result.at, 30U);

  bytes.push_back(0);
  result = msg::cdr_decode(type, bytes, &out);
  EXPECT_STREQ(result.error, "bytes left over behind the message");
  EXPECT_EQ(result.at, bytes.size() - 1);

  bytes[1] = 0;  // big-endian
  EXPECT_STREQ(msg::cdr_decode(type, bytes, &out).error, "not little-endian XCDR1 (00 01 00 00)");
}

TEST(Cdr, BulkIsCheckedAgainstSlotAndFields) {
  const msg::TypeInfo& type = msg::type_info<msg::Image>();
  Slot slot(type);
  auto& image = *static_cast<msg::Image*>(slot.get());
  ASSERT_TRUE(image.format_as(msg::PixelFormat::mono8, 40, 10));
  auto bytes = encoded(type, &image);

  Slot small(type, 399);
  EXPECT_STREQ(msg::cdr_decode(type, bytes, small.get(), 399).error, "bulk does not fit the slot");
  Slot just(type, 400);
  EXPECT_TRUE(msg::cdr_decode(type, bytes, just.get(), 400));
  EXPECT_EQ(static_cast<msg::Image*>(just.get())->capacity_bytes, 400U) << "the slot's own, not the sender's";

  image.height = 9;  // the fields call 360 bytes used; 400 follow
  const auto shorter = encoded(type, &image);
  std::copy(shorter.begin(), shorter.begin() + 4 + sizeof(msg::Image), bytes.begin());
  const auto result = msg::cdr_decode(type, bytes, just.get(), 400);
  EXPECT_STREQ(result.error, "length of the bulk contradicts the fields");
  EXPECT_EQ(result.field, "data");
}

}  // namespace
