#include "msg/json.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "math/hash.hpp"
#include "msg/actuators.hpp"
#include "msg/compare.hpp"
#include "msg/flight.hpp"
#include "msg/image.hpp"
#include "msg/sensors.hpp"
#include "random_message.hpp"

namespace {

using namespace sinew;
using test::kBulkCapacity;
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

TEST(Json, EveryTypeRoundTripsByteEqual) {
  math::Random random(6);
  for (const msg::TypeInfo* type : msg::all_types())
    for (int i = 0; i < 100; ++i) {
      Slot sent = random_message(*type, random);
      msg::canonicalise(*type, sent.get());  // of a NaN only that it is one is written
      std::string text;
      msg::to_json(*type, sent.get(), text, {.bulk = msg::JsonOptions::Bulk::base64});
      Slot received = random_message(*type, random);
      const auto error = msg::from_json(*type, text, received.get(), kBulkCapacity);
      ASSERT_FALSE(error) << type->name << ": " << error->text() << "\n" << text;
      const auto difference = msg::first_difference(*type, sent.get(), received.get());
      ASSERT_FALSE(difference) << type->name << "." << difference->path << " " << difference->a << " " << difference->b;
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

TEST(FromJson, FieldsLeftOutKeepTheirDefaults) {
  msg::NavState nav;
  const auto error =
      msg::from_json(msg::type_info<msg::NavState>(), " { \"height_m\" : 2 ,\n\"v_world_mps\":{\"z\":-1e-3} } ", &nav);
  ASSERT_FALSE(error) << error->text();
  EXPECT_EQ(nav.height_m, 2.0);
  EXPECT_EQ(nav.v_world_mps.z, -1e-3);
  EXPECT_EQ(nav.q_world_base.w, 1.0);
  EXPECT_FALSE(msg::from_json(msg::type_info<msg::NavState>(), "{}", &nav));
  EXPECT_EQ(nav.height_m, 0.0);
}

struct Refusal {
  const char* json;
  const char* text;
};

class FromJsonRefuses : public testing::TestWithParam<Refusal> {};

TEST_P(FromJsonRefuses, AndSaysWhereWhatAndWhatIsAllowed) {
  msg::ActuatorCommand command;
  command.count = 77;
  const auto error = msg::from_json(msg::type_info<msg::ActuatorCommand>(), GetParam().json, &command);
  ASSERT_TRUE(error) << GetParam().json;
  EXPECT_EQ(error->text(), GetParam().text);
  EXPECT_EQ(command.count, 0U) << "left at its defaults";
}

INSTANTIATE_TEST_SUITE_P(
    Texts, FromJsonRefuses,
    testing::Values(
        Refusal{"", "at 0: end of the text: '{'"}, Refusal{"[1]", "at 0: [1: '{'"},
        Refusal{"{\"count\":1", "at 10: end of the text: '}'"},
        Refusal{"{\"count\":1} x", "at 12: text behind the message: nothing"},
        Refusal{"{\"cuont\":1}", "at 1: cuont: no such field: stamp, value, count, armed"},
        Refusal{"{\"count\":1,\"count\":2}", "at 11: count: given twice: once"},
        Refusal{"{\"count\":1,}", "at 11: }: a field's name in quotes"},
        Refusal{"{\"count\" 1}", "at 9: count: 1: ':'"},
        Refusal{"{\"count\":-1}", "at 9: count: -1: an integer from 0 to 4294967295"},
        Refusal{"{\"count\":4294967296}", "at 9: count: 4294967296: an integer from 0 to 4294967295"},
        Refusal{"{\"count\":1.5}", "at 9: count: 1.5: an integer from 0 to 4294967295"},
        Refusal{"{\"count\":01}", "at 9: count: 01: an integer from 0 to 4294967295"},
        Refusal{"{\"count\":\"1\"}", "at 9: count: \"1\": an integer from 0 to 4294967295"},
        Refusal{"{\"stamp\":9223372036854775808}",
                "at 9: stamp: 9223372036854775808: an integer from -9223372036854775808 to 9223372036854775807"},
        Refusal{"{\"value\":1}", "at 9: value: 1: [...] of 8"},
        Refusal{"{\"value\":[1,2]}", "at 13: value: 2 elements: [...] of 8"},
        Refusal{"{\"value\":[1,2,3,4,5,6,7,8,9]}", "at 25: value: more elements: [...] of 8"},
        Refusal{"{\"value\":[1,2,nan]}", "at 14: value[2]: nan: a number, \"NaN\", \"Infinity\" or \"-Infinity\""},
        Refusal{"{\"value\":[\"fast\"]}",
                "at 10: value[0]: \"fast\": a number, \"NaN\", \"Infinity\" or \"-Infinity\""},
        Refusal{"{\"value\":[1e999]}", "at 10: value[0]: 1e999: a number in the range of a double"}));

TEST(FromJson, PathsLeadIntoNestedStructs) {
  msg::ImuSample imu;
  const auto error = msg::from_json(msg::type_info<msg::ImuSample>(), R"({"gyro_radps":{"x":1,"w":2}})", &imu);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->text(), "at 21: gyro_radps.w: no such field: x, y, z");
}

TEST(FromJson, BulkMustBeBase64AndOfTheSizeThatTheFieldsSay) {
  const msg::TypeInfo& type = msg::type_info<msg::Image>();
  Slot slot(type, 16);
  const auto refusal = [&](const std::string& rest) {
    const std::string head = R"({"width":4,"height":1,"stride":4,"format":1)";
    const auto error = msg::from_json(type, head + rest + "}", slot.get(), 16);
    return error ? error->path + ": " + error->what + ": " + error->allowed : "";
  };
  EXPECT_EQ(refusal(R"(,"data":"AH+A/w==")"), "");
  EXPECT_EQ(static_cast<msg::Image*>(slot.get())->pixels()[3], 0xff);
  EXPECT_EQ(refusal(R"(,"capacity_bytes":9999,"data":"AH+A/w==")"), "");
  EXPECT_EQ(static_cast<msg::Image*>(slot.get())->capacity_bytes, 16U);
  EXPECT_EQ(refusal(""), "data: 0 bytes: 4, as the other fields say");
  EXPECT_EQ(refusal(R"(,"data":"AH+A")"), "data: 3 bytes: 4, as the other fields say");
  EXPECT_EQ(refusal(R"(,"data":"AH-A/w==")"), "data: '-' in base64: base64, padded, of at most 16 bytes");
  EXPECT_EQ(refusal(R"(,"data":"AH+A/w")"), "data: \"AH+A/w\": base64, padded, of at most 16 bytes");
  EXPECT_EQ(refusal(",\"data\":\"" + std::string(24, 'A') + "\""),
            "data: 18 bytes: base64, padded, of at most 16 bytes");
  EXPECT_EQ(refusal(R"(,"data":{"bytes":4})"), "data: {\"bytes\":4: base64, padded, of at most 16 bytes");
}

}  // namespace
