#include "msg/json.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "math/hash.hpp"
#include "msg/image.hpp"
#include "msg/sensors.hpp"
#include "random_message.hpp"

namespace {

using namespace sinew;
using test::random_message;
using test::Slot;

template <class T>
T read(const std::uint8_t* p) {
  T v;
  std::memcpy(&v, p, sizeof v);
  return v;
}

template <class F>
void expect_float(const nlohmann::json& j, F value) {
  if (value != value) {
    EXPECT_EQ(j, "NaN");
  } else if (value - value != 0) {
    EXPECT_EQ(j, value > 0 ? "Infinity" : "-Infinity");
  } else {
    ASSERT_TRUE(j.is_number_float()) << j;
    const F parsed = j.get<F>();
    EXPECT_EQ(std::memcmp(&parsed, &value, sizeof value), 0) << j << " " << value;
  }
}

void expect_number(const nlohmann::json& j, msg::Kind kind, const std::uint8_t* p) {
  switch (kind) {
    case msg::Kind::f64:
      return expect_float(j, read<double>(p));
    case msg::Kind::f32:
      return expect_float(j, read<float>(p));
    case msg::Kind::i64:
      EXPECT_EQ(j.get<std::int64_t>(), read<std::int64_t>(p));
      return;
    case msg::Kind::u64:
      EXPECT_EQ(j.get<std::uint64_t>(), read<std::uint64_t>(p));
      return;
    case msg::Kind::i32:
      EXPECT_EQ(j.get<std::int64_t>(), read<std::int32_t>(p));
      return;
    case msg::Kind::u32:
      EXPECT_EQ(j.get<std::int64_t>(), read<std::uint32_t>(p));
      return;
    case msg::Kind::u8:
      EXPECT_EQ(j.get<std::int64_t>(), read<std::uint8_t>(p));
      return;
    default:
      FAIL() << "no message uses this kind yet: extend the test";
  }
}

void expect_object(const nlohmann::json& j, const msg::TypeInfo& type, const std::uint8_t* p) {
  ASSERT_TRUE(j.is_object());
  EXPECT_EQ(j.size(), type.fields.size() + (type.has_bulk() ? 1 : 0)) << type.name;
  for (const msg::FieldInfo& f : type.fields) {
    const nlohmann::json& value = j.at(std::string(f.name));
    EXPECT_EQ(value.is_array(), f.is_array) << f.name;
    ASSERT_TRUE(!f.is_array || value.size() == f.count) << f.name;
    for (std::uint32_t i = 0; i < f.count; ++i) {
      const nlohmann::json& element = f.is_array ? value.at(i) : value;
      if (f.kind == msg::Kind::nested)
        expect_object(element, *f.nested, p + f.offset + i * f.nested->size);
      else
        expect_number(element, f.kind, p + f.offset + i * msg::size_of(f.kind));
    }
  }
}

TEST(Json, AnIndependentParserReadsTheSameValuesOfEveryType) {
  math::Random random(5);
  for (const msg::TypeInfo* type : msg::all_types())
    for (int i = 0; i < 100; ++i) {
      Slot slot = random_message(*type, random);
      std::string text;
      msg::to_json(*type, slot.get(), text);
      const auto parsed = nlohmann::json::parse(text, nullptr, false);
      ASSERT_FALSE(parsed.is_discarded()) << text;
      expect_object(parsed, *type, slot.bytes());
    }
}

TEST(Json, TextOfASampleIsShortAndInOrder) {
  msg::ImuSample m;
  m.stamp.ns = -5;
  m.gyro_radps = {0.1, -0.0, 1e300};
  m.accel_mps2 = {std::numeric_limits<double>::quiet_NaN(), -std::numeric_limits<double>::infinity(), 9.81};
  std::string text = "> ";
  msg::to_json(msg::type_info<msg::ImuSample>(), &m, text);
  EXPECT_EQ(text, R"(> {"stamp":-5,"gyro_radps":{"x":0.1,"y":-0.0,"z":1e+300},)"
                  R"("accel_mps2":{"x":"NaN","y":"-Infinity","z":9.81}})");
}

TEST(Json, BulkIsSummarisedOrWrittenOut) {
  const msg::TypeInfo& type = msg::type_info<msg::Image>();
  Slot slot(type);
  auto& image = *static_cast<msg::Image*>(slot.get());
  ASSERT_TRUE(image.format_as(msg::PixelFormat::mono8, 4, 1));
  std::memcpy(image.pixels(), "\x00\x7f\x80\xff", 4);
  const auto data = [&](const msg::JsonOptions& options) {
    std::string text;
    msg::to_json(type, &image, text, options);
    return nlohmann::json::parse(text).at("data").dump();
  };
  EXPECT_EQ(data({}), R"({"bytes":4})");
  char hash[20];
  std::snprintf(hash, sizeof hash, "%016llx", static_cast<unsigned long long>(math::hash64(image.pixels(), 4)));
  EXPECT_EQ(data({.bulk_hash = &math::hash64}), R"({"bytes":4,"hash":")" + std::string(hash) + "\"}");
  EXPECT_EQ(data({.bulk = msg::JsonOptions::Bulk::hex}), R"("007f80ff")");
  EXPECT_EQ(data({.bulk = msg::JsonOptions::Bulk::base64}), R"("AH+A/w==")");
}

}  // namespace
