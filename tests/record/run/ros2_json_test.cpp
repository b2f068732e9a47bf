#include "record/run/ros2_json.hpp"

#include <gmock/gmock.h>

#include "math/hash.hpp"
#include "msg/all.hpp"
#include "msg/cdr.hpp"
#include "msg/json.hpp"
#include "msg/ros2msg.hpp"
#include "record/run/cdr_stream.hpp"
#include "record/run/run_messages.hpp"

namespace sinew::record::ros2_json_test {
namespace {

std::string json_of(std::string_view text, std::span<const std::byte> cdr) {
  std::string why, out;
  const auto schema = Ros2Schema::parse("test_msgs/msg/Test", text, why);
  if (!schema) return "no schema: " + why;
  return to_json(*schema, cdr, out) ? out : "no message" + out;
}

TEST(Ros2Json, EveryTypeOfOursReadsAsItsOwnJson) {
  std::uint64_t state = 1;
  for (const msg::TypeInfo* type : msg::all_types()) {
    if (type->has_bulk()) continue;
    std::vector<std::byte> message(type->size);
    for (int round = 0; round < 20; ++round) {
      for (std::byte& b : message) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        b = static_cast<std::byte>(state >> 56);
      }
      std::vector<std::byte> cdr(msg::cdr_size(*type, message.data()));
      msg::cdr_encode(*type, message.data(), {reinterpret_cast<std::uint8_t*>(cdr.data()), cdr.size()});
      std::string expected;
      msg::to_json(*type, message.data(), expected);
      EXPECT_EQ(json_of(msg::ros2msg_schema(*type), cdr), expected) << type->name;
    }
  }
}

TEST(Ros2Json, StepsHaveEveryFieldAndAlignment) {
  LoggedStep step;
  step.order = 7, step.thread = 2, step.module = 3, step.timed_out = true;
  step.inputs.push_back({1, true, 4, {8, 9}});
  step.inputs.push_back({2, false, 0, {}});
  step.outputs.push_back({5, 10, 1, {11, -1}});
  StepBatch batch;
  batch.add(step);
  batch.add(step);
  const std::string one =
      R"({"order":7,"release_ns":0,"now_ns":0,"completed_ns":0,"dt_ns":0,"exec_ns":0,"module":3,"number":0,)"
      R"("device_state":0,"status":0,"timed_out":true,"inputs":[)"
      R"({"port":1,"dropped":4,"updated":true,"sequences":[8,9]},{"port":2,"dropped":0,"updated":false,"sequences":[]}],)"
      R"("outputs":[{"port":5,"first":10,"count":1,"origin_ns":[11,-1]}]})";
  EXPECT_EQ(json_of(step_batch_schema().text, batch.bytes()), R"({"thread":2,"steps":[)" + one + "," + one + "]}");
}

TEST(Ros2Json, DefinitionsOfOthersAreUnderstood) {
  constexpr std::string_view kText = R"(# A comment
int32 CONSTANT=5
string<=10 name "default"   # with a default
bool[2] flags
float32[<=3] some
Time when
Inner[] inside
char c 3
================================================================================
MSG: test_msgs/Inner
string TEXT = "a # b"
builtin_interfaces/Time stamp
)";
  Buffer bytes;
  CdrWriter cdr(bytes);
  cdr.text("a \"b\"\n\xFF");
  cdr.boolean(true), cdr.boolean(false);
  cdr.length(1), cdr.number(std::uint32_t{0x3F800000});
  cdr.number(std::int32_t{-1}), cdr.number(std::uint32_t{5});
  cdr.length(1), cdr.number(std::int32_t{2}), cdr.number(std::uint32_t{6});
  cdr.number(std::uint8_t{7});
  std::string text(kText);
  text.replace(text.find("Time when"), 4, "builtin_interfaces/Time");
  EXPECT_EQ(json_of(text, bytes.bytes()),
            R"({"name":"a \"b\"\u000a\u00ff","flags":[true,false],"some":[1.0],"when":{"sec":-1,"nanosec":5},)"
            R"("inside":[{"stamp":{"sec":2,"nanosec":6}}],"c":7})");
}

TEST(Ros2Json, WhatIsNotAMessageIsRefusedAndNothingIsShown) {
  Buffer bytes;
  CdrWriter cdr(bytes);
  cdr.number(std::uint32_t{1});
  EXPECT_EQ(json_of("uint32 x", bytes.bytes()), R"({"x":1})");
  EXPECT_EQ(json_of("uint64 x", bytes.bytes()), "no message") << "too short";
  EXPECT_EQ(json_of("uint16 x", bytes.bytes()), "no message") << "bytes are left";
  EXPECT_EQ(json_of("uint32[4000000000] x", bytes.bytes()), "no message");
  EXPECT_EQ(json_of("uint32 x", bytes.bytes().first(3)), "no message");
}

TEST(Ros2Json, BadDefinitionsSayWhy) {
  EXPECT_EQ(json_of("Nothing x", {}), "no schema: the type Nothing is not defined");
  EXPECT_EQ(json_of("uint32", {}), "no schema: not a field: uint32");
  EXPECT_EQ(json_of("uint32[x] a", {}), "no schema: not a field: uint32[x] a");
  EXPECT_THAT(json_of("A a\n===\nMSG: test_msgs/A\nA[] again\n", {}), ::testing::HasSubstr("contains itself"));
}

}  // namespace
}  // namespace sinew::record::ros2_json_test
