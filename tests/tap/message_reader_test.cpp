// Messages that come in as JSON.
#include "tap/message_reader.hpp"

#include <gtest/gtest.h>

#include "../msg/random_message.hpp"
#include "msg/actuators.hpp"
#include "msg/compare.hpp"
#include "msg/flight.hpp"
#include "msg/json.hpp"
#include "msg/operator.hpp"
#include "msg/sensors.hpp"

namespace sinew::tap::message_reader_test {
namespace {

using Json = nlohmann::ordered_json;

template <class M>
std::optional<std::string> read(const char* text, M& message) {
  return read_message(msg::type_info<M>(), Json::parse(text, nullptr, false), &message);
}

TEST(MessageReader, EveryTypeComesBackByteEqual) {
  math::Random random(6);
  for (const msg::TypeInfo* type : msg::all_types())
    for (int i = 0; i < 100 && !type->has_bulk(); ++i) {
      test::Slot sent = test::random_message(*type, random);
      msg::canonicalise(*type, sent.get());  // of a NaN only that it is one is written
      std::string text;
      msg::to_json(*type, sent.get(), text);
      test::Slot received = test::random_message(*type, random);
      const auto wrong = read_message(*type, Json::parse(text), received.get());
      ASSERT_FALSE(wrong) << type->name << ": " << *wrong << "\n" << text;
      const auto difference = msg::first_difference(*type, sent.get(), received.get());
      ASSERT_FALSE(difference) << type->name << "." << difference->path << " " << difference->a << " " << difference->b;
    }
}

TEST(MessageReader, FieldsLeftOutKeepTheirDefaults) {
  msg::NavState nav;
  EXPECT_EQ(read(R"({"height_m": 2, "v_world_mps": {"z": -1e-3}})", nav), std::nullopt);
  EXPECT_EQ(nav.height_m, 2.0);
  EXPECT_EQ(nav.v_world_mps.z, -1e-3);
  EXPECT_EQ(nav.q_world_base.w, 1.0);
  EXPECT_EQ(read("{}", nav), std::nullopt);
  EXPECT_EQ(nav.height_m, 0.0);
}

TEST(MessageReader, TakesNamesOfValuesAndBits) {
  msg::GuardianState state;
  EXPECT_EQ(read(R"({"mode": "active", "faults": "lease, not finite"})", state), std::nullopt);
  EXPECT_EQ(state.mode, msg::GuardianMode::active);
  EXPECT_EQ(state.faults, msg::kFaultLease | msg::kFaultNotFinite);
  EXPECT_EQ(read(R"({"mode": 3, "faults": "none"})", state), std::nullopt);
  EXPECT_EQ(state.mode, msg::GuardianMode::safe);
  EXPECT_EQ(state.faults, 0U);
  EXPECT_EQ(read(R"({"mode": "activ"})", state),
            "mode: \"activ\": one of standby, armed, active, safe; did you mean active?");
  EXPECT_EQ(read(R"({"faults": "lease, late"})", state),
            "faults: \"lease, late\": some of lease, not finite, limit, rate, count, device, failsafe");
}

TEST(MessageReader, SaysWhereWhatAndWhatIsAllowed) {
  constexpr std::pair<const char*, const char*> kTexts[] = {
      {"[1]", "[1]: {...}"},
      {"{\"cuont\":1}", "cuont: no such field: stamp, value, count, armed"},
      {"{\"count\":-1}", "count: -1: an integer from 0 to 4294967295"},
      {"{\"count\":4294967296}", "count: 4294967296: an integer from 0 to 4294967295"},
      {"{\"count\":1.5}", "count: 1.5: an integer from 0 to 4294967295"},
      {"{\"count\":\"1\"}", "count: \"1\": an integer from 0 to 4294967295"},
      {"{\"stamp\":9223372036854775808}",
       "stamp: 9223372036854775808: an integer from -9223372036854775808 to 9223372036854775807"},
      {"{\"value\":1}", "value: 1: [...] of 8"},
      {"{\"value\":[1,2]}", "value: 2 elements: [...] of 8"},
      {"{\"value\":[1,2,3,4,5,6,7,null]}", "value[7]: null: a number, \"NaN\", \"Infinity\" or \"-Infinity\""},
      {"{\"value\":[\"fast\",2,3,4,5,6,7,8]}", "value[0]: \"fast\": a number, \"NaN\", \"Infinity\" or \"-Infinity\""}};
  for (const auto& [text, says] : kTexts) {
    msg::ActuatorCommand command;
    command.count = 77;
    EXPECT_EQ(read(text, command), says);
    EXPECT_EQ(command.count, 0U) << "left at its defaults";
  }
  msg::ImuSample imu;
  EXPECT_EQ(read(R"({"gyro_radps":{"x":1,"w":2}})", imu), "gyro_radps.w: no such field: x, y, z");
  EXPECT_EQ(read(R"({"gyro_radps":"as fast as it possibly can"})", imu),
            "gyro_radps: \"as fast as it possib...: {...}");
  msg::OperatorLink link;
  EXPECT_EQ(read(R"({"quality":1e39})", link), "quality: 1e+39: a number in the range of a float");
}

}  // namespace
}  // namespace sinew::tap::message_reader_test
