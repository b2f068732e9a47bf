#include "wire/pcap_can.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "wire/random_can_frame.hpp"

namespace sinew::wire::pcap_can_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes record(msg::CanFrame frame, std::int64_t ns = 0) {
  frame.stamp.ns = ns;
  Bytes out(kPcapCanMax);
  out.resize(pcap_can_record(frame, out));
  return out;
}

TEST(PcapCan, FileBeginsAsTheFormatSays) {
  const auto head = pcap_can_head();
  EXPECT_EQ(Bytes(head.begin(), head.end()),
            (Bytes{0x4D, 0x3C, 0xB2, 0xA1, 2, 0, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF, 0, 0, 227, 0, 0, 0}));
}

TEST(PcapCan, RecordsHaveTheIdentifierBigEndian) {
  EXPECT_EQ(record(frame_of(0x601, {0x40, 0x41, 0x60}), 1'000'000'007),
            (Bytes{1, 0, 0, 0, 7, 0, 0, 0, 11, 0, 0, 0, 11, 0, 0, 0, 0, 0, 6, 1, 3, 0, 0, 0, 0x40, 0x41, 0x60}));
  EXPECT_EQ(record(frame_of(0x01020304, {}, msg::kCanExtended)),
            (Bytes{0, 0, 0, 0, 0, 0, 0, 0, 8, 0, 0, 0, 8, 0, 0, 0, 0x81, 2, 3, 4, 0, 0, 0, 0}));
  EXPECT_EQ(record(frame_of(0x40, {9}, msg::kCanError))[16], 0x20);
  EXPECT_EQ(record(frame_of(1, {}, msg::kCanRemote))[16], 0x40);
  EXPECT_EQ(record(frame_of(1, {5}, msg::kCanFd | msg::kCanBitRateSwitch))[21], 5) << "FD and its faster data";
}

TEST(PcapCan, WhatDoesNotFitIsNotWritten) {
  Bytes small(26);
  EXPECT_EQ(pcap_can_record(frame_of(1, {1, 2, 3}), small), 0u);
  EXPECT_TRUE(record(frame_of(1, {1}), -1).empty());
  EXPECT_TRUE(record(frame_of(1, {1}), 5'000'000'000ll * 1'000'000'000).empty()) << "after the year 2106";
}

}  // namespace
}  // namespace sinew::wire::pcap_can_test
