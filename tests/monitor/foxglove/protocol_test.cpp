#include "monitor/foxglove/protocol.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <nlohmann/json.hpp>

namespace sinew::foxglove::protocol_test {
namespace {

std::string why_of(bool binary, std::string_view text) {
  std::string why;
  const auto message = parse(binary, std::as_bytes(std::span(text)), why);
  EXPECT_FALSE(message) << text;
  return why;
}

TEST(ProtocolTest, WhatIsWrongInAMessageIsSaid) {
  EXPECT_EQ(why_of(false, "["), "a JSON object with \"op\"");
  EXPECT_EQ(why_of(false, "{}"), "\"op\": a text");
  EXPECT_EQ(why_of(false, R"({"op":"dance"})"), "unknown op \"dance\"");
  EXPECT_EQ(why_of(false, R"({"op":"subscribe"})"), "\"subscriptions\": a list");
  EXPECT_EQ(why_of(false, R"({"op":"subscribe","subscriptions":[{"id":-1,"channelId":2}]})"),
            "\"id\": an integer from 0 to 4294967295");
  EXPECT_EQ(why_of(false, R"({"op":"subscribe","subscriptions":[7]})"), "\"id\": an integer from 0 to 4294967295");
  EXPECT_EQ(why_of(false, R"({"op":"unsubscribe","subscriptionIds":["1"]})"),
            "\"subscriptionIds\": a list of integers from 0 to 4294967295");
  EXPECT_EQ(why_of(false, std::string(100, '[')), "nested too deep");
  EXPECT_EQ(why_of(true, ""), "unknown binary message");
  EXPECT_EQ(why_of(true, std::string("\x01\x00", 2)), "a binary message ends too early");
  EXPECT_EQ(why_of(true, std::string("\x02\x01\0\0\0\x01\0\0\0\xFF\xFF\xFF\xFFjson", 17)),
            "a binary message ends too early");
}

TEST(ProtocolTest, AServiceCallIsReadFromItsBytes) {
  const std::string bytes("\x02\x05\0\0\0\x06\0\0\0\x04\0\0\0json{}", 19);
  std::string why;
  const auto message = parse(true, std::as_bytes(std::span(bytes)), why);
  ASSERT_TRUE(message) << why;
  const auto& call = std::get<ServiceCall>(*message);
  EXPECT_EQ(call.service, 5u);
  EXPECT_EQ(call.call, 6u);
  EXPECT_EQ(call.encoding, "json");
  EXPECT_EQ(call.payload, "{}");
}

TEST(ProtocolTest, PlaybackControlIsReadFromItsBytes) {
  // Command pause, speed 1, no seek (its time is there all the same), request "id".
  const std::string bytes("\x03\x01\0\0\x80\x3F\0\0\0\0\0\0\0\0\0\x02\0\0\0id", 21);
  std::string why;
  const auto message = parse(true, std::as_bytes(std::span(bytes)), why);
  ASSERT_TRUE(message) << why;
  const auto& control = std::get<PlaybackControl>(*message);
  EXPECT_FALSE(control.play);
  EXPECT_EQ(control.speed, 1.0F);
  EXPECT_FALSE(control.seek_ns);
  EXPECT_EQ(control.request, "id");
  std::string bad = bytes;
  bad[4] = '\xC0', bad[5] = '\x7F';  // NaN
  EXPECT_EQ(why_of(true, bad), "playback: command 0 or 1, and a finite speed");
}

TEST(ProtocolTest, TextThatIsNoUtf8IsSentAsText) {
  EXPECT_TRUE(nlohmann::json::accept(status(StatusLevel::error, "\xFF\xFE")));
}

}  // namespace
}  // namespace sinew::foxglove::protocol_test
