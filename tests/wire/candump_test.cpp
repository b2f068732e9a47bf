#include "wire/candump.hpp"

#include <gtest/gtest.h>

#include <string>

#include "wire/random_can_frame.hpp"

namespace sinew::wire::candump_test {
namespace {

std::string formatted(const msg::CanFrame& frame, std::string_view interface = "can0") {
  std::string out(kCandumpMax, ' ');
  out.resize(candump_format(frame, interface, out));
  return out;
}

std::string why(std::string_view line) {
  CandumpLine out;
  const char* problem = candump_parse(line, out);
  return problem ? problem : "";
}

TEST(Candump, LinesOfALogAreRead) {
  CandumpLine line;
  ASSERT_EQ(candump_parse("(1436509052.249713) vcan0 044#2A366C2BBA\n", line), nullptr);
  EXPECT_EQ(line.frame.stamp.ns, 1436509052249713000);
  EXPECT_EQ(line.interface, "vcan0");
  EXPECT_TRUE(same_frame(line.frame, frame_of(0x44, {0x2A, 0x36, 0x6C, 0x2B, 0xBA})));

  ASSERT_EQ(candump_parse("(0000000000.000001) can1 1F334455#1122334455667788_B T", line), nullptr);
  EXPECT_TRUE(same_frame(line.frame,
                         frame_of(0x1F334455, {0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x77, 0x88}, msg::kCanExtended)));

  ASSERT_EQ(candump_parse("(1.5) can0 123##111.22", line), nullptr);
  EXPECT_TRUE(same_frame(line.frame, frame_of(0x123, {0x11, 0x22}, msg::kCanFd | msg::kCanBitRateSwitch)));
  EXPECT_EQ(line.frame.stamp.ns, 1500000000);

  ASSERT_EQ(candump_parse("(1.5) can0 123#R", line), nullptr);
  EXPECT_TRUE(same_frame(line.frame, frame_of(0x123, {}, msg::kCanRemote)));
  ASSERT_EQ(candump_parse("(1.5) can0 123#R4", line), nullptr);
  EXPECT_EQ(line.frame.size, 4u);

  ASSERT_EQ(candump_parse("(1.5) can0 20000040#0000000000000000", line), nullptr) << "an error frame: bus off";
  EXPECT_TRUE(line.frame.error());
  EXPECT_EQ(line.frame.id, 0x40u);
}

TEST(Candump, FramesAreWrittenAsCandumpWritesThem) {
  msg::CanFrame frame = frame_of(0x44, {0x2A, 0x36});
  frame.stamp.ns = 1436509052249713000;
  EXPECT_EQ(formatted(frame, "vcan0"), "(1436509052.249713) vcan0 044#2A36");
  frame = frame_of(0x1234, {0xFF}, msg::kCanExtended | msg::kCanFd | msg::kCanBitRateSwitch);
  EXPECT_EQ(formatted(frame), "(0.000000) can0 00001234##1FF");
  EXPECT_EQ(formatted(frame_of(0x40, {0}, msg::kCanError)), "(0.000000) can0 20000040#00");
  EXPECT_EQ(formatted(frame_of(0x7FF, {}, msg::kCanRemote)), "(0.000000) can0 7FF#R");
}

TEST(Candump, EveryFrameComesBackAsItWas) {
  std::mt19937 random(2);
  for (int i = 0; i < 5000; ++i) {
    msg::CanFrame frame = random_can_frame(random, true, true);
    frame.stamp.ns =
        static_cast<std::int64_t>(random()) * 1000000000 + static_cast<std::int64_t>(random() % 1000000) * 1000;
    CandumpLine line;
    const std::string text = formatted(frame);
    ASSERT_EQ(candump_parse(text, line), nullptr) << text;
    ASSERT_TRUE(same_frame(frame, line.frame)) << text;
    ASSERT_EQ(frame.stamp.ns, line.frame.stamp.ns) << text;
  }
}

TEST(Candump, WrongLinesSayWhatIsWrong) {
  EXPECT_EQ(why(""), "begins with (SECONDS.MICROSECONDS)");
  EXPECT_EQ(why("(12) can0 123#"), "time: (SECONDS.MICROSECONDS)");
  EXPECT_EQ(why("(99999999999.0) can0 123#"), "time: (SECONDS.MICROSECONDS)");
  EXPECT_EQ(why("(9999999999.0) can0 123#"), "time: (SECONDS.MICROSECONDS)")
      << "would not fit in 64 bits of nanoseconds";
  EXPECT_EQ(why("(1.0) "), "name of an interface, at most 15 characters");
  EXPECT_EQ(why("(1.0) can0 123"), "IDENTIFIER#DATA");
  EXPECT_EQ(why("(1.0) can0 12#"), "identifier: three or eight hex digits");
  EXPECT_EQ(why("(1.0) can0 800#"), "identifier of three digits above 7FF");
  EXPECT_EQ(why("(1.0) can0 80000123#"), "identifier of eight digits above 3FFFFFFF");
  EXPECT_EQ(why("(1.0) can0 123#1"), "data: two hex digits a byte");
  EXPECT_EQ(why("(1.0) can0 123#112233445566778899"), "more data than a frame can have");
  EXPECT_EQ(why("(1.0) can0 123##0112233445566778899"), "no CAN FD frame has this many bytes");
  EXPECT_EQ(why("(1.0) can0 123##8"), "CAN FD flags: one digit 0..7");
  EXPECT_EQ(why("(1.0) can0 123#R9"), "remote frames ask for 0..8 bytes");
  EXPECT_EQ(why("(1.0) can0 123#11_9"), "a raw DLC 9..F follows eight bytes only");
  EXPECT_EQ(why("(1.0) can0 123#11 X"), "text after the data");
}

TEST(Candump, WhatDoesNotFitIsNotWritten) {
  std::string small(20, ' ');
  EXPECT_EQ(candump_format(frame_of(0x123, {1, 2, 3, 4}), "can0", small), 0u);
  EXPECT_TRUE(formatted(frame_of(0x123, {}), "a_name_that_is_too_long").empty());
  EXPECT_TRUE(formatted(frame_of(0x800, {})).empty());
}

}  // namespace
}  // namespace sinew::wire::candump_test
