#include "msg/compare.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "math/hash.hpp"
#include "msg/flight.hpp"
#include "msg/image_buffer.hpp"
#include "msg/sensors.hpp"
#include "random_message.hpp"

namespace {

using namespace sinew;
using test::random_message;
using test::Slot;

std::uint64_t hash_of(const msg::TypeInfo& type, const void* message) {
  math::Hash64 h;
  msg::add_to_hash(h, type, message);
  return h.value();
}

template <class F>
bool is_canonical(const std::uint8_t* p) {
  F value;
  std::memcpy(&value, p, sizeof value);
  if (value == value) return true;
  // Positive, payload 0; not what the C++ library calls a quiet NaN, which is another one on MIPS.
  constexpr auto kBits = std::conditional_t<sizeof(F) == 8, std::uint64_t, std::uint32_t>(
      sizeof(F) == 8 ? 0x7ff8000000000000u : 0x7fc00000u);
  return std::memcmp(&value, &kBits, sizeof value) == 0;
}

void expect_canonical(const msg::TypeInfo& type, const std::uint8_t* p) {
  for (const msg::FieldInfo& f : type.fields)
    for (std::uint32_t i = 0; i < f.count; ++i) {
      if (f.kind == msg::Kind::nested) expect_canonical(*f.nested, p + f.offset + i * f.nested->size);
      const bool ok = f.kind == msg::Kind::f64   ? is_canonical<double>(p + f.offset + i * 8)
                      : f.kind == msg::Kind::f32 ? is_canonical<float>(p + f.offset + i * 4)
                                                 : true;
      EXPECT_TRUE(ok) << f.name;
    }
}

TEST(Compare, EveryNanBecomesTheCanonicalOneAndNothingElseChanges) {
  math::Random random(1);
  std::size_t changed_messages = 0;
  for (const msg::TypeInfo* type : msg::all_types())
    for (int i = 0; i < 200; ++i) {
      Slot slot = random_message(*type, random);
      Slot before = slot;
      msg::canonicalise(*type, slot.get());
      expect_canonical(*type, slot.bytes());
      // Every changed number was a NaN.
      const auto difference = msg::first_difference(*type, before.get(), slot.get());
      if (difference) {
        ++changed_messages;
        EXPECT_EQ(difference->a.substr(0, 3), "NaN") << difference->path;
        EXPECT_EQ(difference->b.substr(0, 3), "NaN") << difference->path;
      }
      Slot again = slot;
      msg::canonicalise(*type, again.get());
      EXPECT_TRUE(msg::equal(*type, slot.get(), again.get()));
    }
  EXPECT_GT(changed_messages, 0U);
}

TEST(Compare, SignallingAndNegativeNansAreNansButInfinityIsNot) {
  msg::RangeSample range;
  for (const std::uint64_t bits : {0x7ff0000000000001ull, 0xfff8000000000000ull, 0xffffffffffffffffull}) {
    range.range_m = std::bit_cast<double>(bits);
    msg::canonicalise(msg::type_info<msg::RangeSample>(), &range);
    EXPECT_EQ(std::bit_cast<std::uint64_t>(range.range_m), 0x7ff8000000000000u);
  }
  range.range_m = -std::numeric_limits<double>::infinity();
  msg::canonicalise(msg::type_info<msg::RangeSample>(), &range);
  EXPECT_TRUE(std::isinf(range.range_m));
}

TEST(Compare, AChangedByteChangesEqualityHashAndIsNamed) {
  math::Random random(2);
  for (const msg::TypeInfo* type : msg::all_types()) {
    if (type->has_bulk()) continue;
    const Slot a = random_message(*type, random);
    for (std::uint32_t byte = 0; byte < type->size; ++byte) {
      Slot b = a;
      b.bytes()[byte] ^= static_cast<std::uint8_t>(1U << random.below(8));
      ASSERT_FALSE(msg::equal(*type, a.get(), b.get())) << type->name << " byte " << byte;
      ASSERT_NE(hash_of(*type, a.get()), hash_of(*type, b.get())) << type->name << " byte " << byte;
      const auto difference = msg::first_difference(*type, a.get(), b.get());
      ASSERT_TRUE(difference) << type->name << " byte " << byte;
      ASSERT_NE(difference->a, difference->b) << difference->path;
    }
    EXPECT_TRUE(msg::equal(*type, a.get(), a.get()));
    EXPECT_FALSE(msg::first_difference(*type, a.get(), a.get()));
  }
}

TEST(Compare, DifferencesAreNamedByPathAndValue) {
  msg::ImuSample a, b;
  b.gyro_radps.y = 0.25;
  auto d = msg::first_difference(msg::type_info<msg::ImuSample>(), &a, &b);
  ASSERT_TRUE(d);
  EXPECT_EQ(d->path, "gyro_radps.y");
  EXPECT_EQ(d->a, "0.0");
  EXPECT_EQ(d->b, "0.25");

  msg::MotionField m, n;
  n.y[17] = std::bit_cast<float>(0xffc00000u);
  m.y[17] = std::bit_cast<float>(0x7fc00000u);
  d = msg::first_difference(msg::type_info<msg::MotionField>(), &m, &n);
  ASSERT_TRUE(d);
  EXPECT_EQ(d->path, "y[17]");
  EXPECT_EQ(d->a, "NaN 0x7fc00000");
  EXPECT_EQ(d->b, "NaN 0xffc00000");
}

TEST(Compare, OnlyTheUsedBulkCounts) {
  const msg::TypeInfo& type = msg::type_info<msg::Image>();
  msg::ImageBuffer a(1000), b(1000);
  ASSERT_TRUE(a->format_as(msg::PixelFormat::mono8, 20, 10));
  ASSERT_TRUE(b->format_as(msg::PixelFormat::mono8, 20, 10));
  b->pixels()[200] = 1;  // first byte behind the used ones
  EXPECT_TRUE(msg::equal(type, &*a, &*b));
  EXPECT_EQ(hash_of(type, &*a), hash_of(type, &*b));
  EXPECT_FALSE(msg::first_difference(type, &*a, &*b));
  b->pixels()[199] = 7;
  EXPECT_FALSE(msg::equal(type, &*a, &*b));
  EXPECT_NE(hash_of(type, &*a), hash_of(type, &*b));
  const auto d = msg::first_difference(type, &*a, &*b);
  ASSERT_TRUE(d);
  EXPECT_EQ(d->path, "data[199]");
  EXPECT_EQ(d->a + " " + d->b, "0 7");
}

}  // namespace
