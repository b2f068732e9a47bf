// Fields shown by what their definition says of them.
#include "apps/bag/field_remark.hpp"

#include <gtest/gtest.h>

#include "msg/behaviour.hpp"
#include "msg/ros2msg.hpp"

namespace sinew::app::field_remark_test {
namespace {

using Json = nlohmann::ordered_json;

record::Ros2Schema behaviour_schema() {
  std::string why;
  const auto& type = msg::type_info<msg::BehaviourState>();
  auto schema = record::Ros2Schema::parse(msg::ros2_name(type), msg::ros2msg_schema(type), why);
  EXPECT_TRUE(schema) << why;
  return schema.value();
}

TEST(FieldRemark, BytesOfTextAreShownAsText) {
  Json message{{"depth", 1}, {"active", {{{"option", {112, 108, 97, 121, 0, 120}}, {"state", {7, 200, 34, 97}}}}}};
  Json beside = message;
  put_names(message, behaviour_schema());
  EXPECT_EQ(message["active"][0]["option"], "play");
  EXPECT_EQ(message["active"][0]["state"], "??\"a");  // not printable: never raw bytes on a terminal
  EXPECT_EQ(message["depth"], 1);
  add_names(beside, behaviour_schema());
  EXPECT_EQ(beside["active"][0]["option"].size(), 6U);
  EXPECT_EQ(beside["active"][0]["option_name"], "play");
}

}  // namespace
}  // namespace sinew::app::field_remark_test
