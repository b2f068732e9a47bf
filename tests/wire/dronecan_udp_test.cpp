#include "wire/dronecan_udp.hpp"

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "wire/crc_ccitt.hpp"
#include "wire/random_can_frame.hpp"

namespace sinew::wire::dronecan_udp_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes encoded(const msg::CanFrame& frame) {
  Bytes out(kDronecanUdpMax);
  out.resize(dronecan_udp_encode(frame, out));
  return out;
}

TEST(DronecanUdp, CrcHasTheCheckValueOfItsDefinition) {
  const std::array<std::uint8_t, 9> check{'1', '2', '3', '4', '5', '6', '7', '8', '9'};
  EXPECT_EQ(crc_ccitt(check), 0x29B1);
}

// Bytes of the packets: struct.pack and binascii.crc_hqx(…, 0xFFFF) of Python, after mcast.py.
TEST(DronecanUdp, FramesHaveTheBytesOfTheReferenceDriver) {
  EXPECT_EQ(encoded(frame_of(0x0804062A, {0x00, 0x03, 0xFD, 0xF0, 0x08, 0x00, 0x10, 0xC5}, msg::kCanExtended)),
            (Bytes{0x34, 0x29, 0x76, 0x27, 0x00, 0x00, 0x2A, 0x06, 0x04, 0x88, 0x00, 0x03, 0xFD, 0xF0, 0x08, 0x00, 0x10,
                   0xC5}));
  EXPECT_EQ(encoded(frame_of(0x123, {})), (Bytes{0x34, 0x29, 0xB2, 0x95, 0x00, 0x00, 0x23, 0x01, 0x00, 0x00}));
  EXPECT_EQ(encoded(frame_of(0x7FF, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}, msg::kCanFd)),
            (Bytes{0x34, 0x29, 0xDA, 0xA7, 0x01, 0x00, 0xFF, 0x07, 0x00, 0x00, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}));
}

TEST(DronecanUdp, EveryFrameComesBackAsItWas) {
  std::mt19937 random(1);
  for (int i = 0; i < 5000; ++i) {
    const msg::CanFrame frame = random_can_frame(random, false, true);
    msg::CanFrame back;
    back.data.fill(0xEE);
    ASSERT_TRUE(dronecan_udp_decode(encoded(frame), back));
    ASSERT_TRUE(same_frame(frame, back)) << i;
  }
}

TEST(DronecanUdp, FramesThatTheFramingCannotCarryAreRefused) {
  EXPECT_TRUE(encoded(frame_of(0x123, {}, msg::kCanRemote)).empty());
  EXPECT_TRUE(encoded(frame_of(0x123, {}, msg::kCanError)).empty());
  EXPECT_TRUE(encoded(frame_of(0x800, {})).empty()) << "12 bits without the extended flag";
  EXPECT_TRUE(encoded(frame_of(0x20000000, {}, msg::kCanExtended)).empty());
  EXPECT_TRUE(encoded(frame_of(1, {1, 2, 3, 4, 5, 6, 7, 8, 9}, msg::kCanFd)).empty()) << "no FD frame has 9 bytes";
  std::array<std::uint8_t, kDronecanUdpHead> small{};
  EXPECT_EQ(dronecan_udp_encode(frame_of(1, {1}), small), 0u);
}

TEST(DronecanUdp, AnyChangedBitIsNoticed) {
  const Bytes good = encoded(frame_of(0x0804062A, {1, 2, 3}, msg::kCanExtended));
  msg::CanFrame out;
  ASSERT_TRUE(dronecan_udp_decode(good, out));
  for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
    Bytes bad = good;
    bad[bit / 8] = static_cast<std::uint8_t>(bad[bit / 8] ^ (1u << bit % 8));
    EXPECT_FALSE(dronecan_udp_decode(bad, out)) << bit;
  }
  for (std::size_t size = 0; size < good.size(); ++size)
    EXPECT_FALSE(dronecan_udp_decode(std::span(good).first(size), out)) << size;
}

/// A datagram with a right CRC and an impossible frame.
Bytes with_crc(Bytes packet) {
  const std::uint16_t crc = crc_ccitt(std::span(packet).subspan(4));
  packet[2] = static_cast<std::uint8_t>(crc), packet[3] = static_cast<std::uint8_t>(crc >> 8);
  return packet;
}

TEST(DronecanUdp, FramesThatCannotBeAreRefusedInSpiteOfTheirCrc) {
  msg::CanFrame out;
  EXPECT_TRUE(dronecan_udp_decode(with_crc({0x34, 0x29, 0, 0, 0, 0, 0xFF, 0x07, 0, 0}), out));
  EXPECT_FALSE(dronecan_udp_decode(with_crc({0x34, 0x29, 0, 0, 0, 0, 0x00, 0x08, 0, 0}), out)) << "12 bits";
  EXPECT_FALSE(dronecan_udp_decode(with_crc({0x34, 0x29, 0, 0, 0, 0, 0, 0, 0, 0x40}), out)) << "bit 30";
  EXPECT_FALSE(dronecan_udp_decode(with_crc({0x34, 0x29, 0, 0, 0, 0, 0, 1, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9}), out));
  EXPECT_FALSE(dronecan_udp_decode(with_crc(Bytes(75)), out)) << "longer than any";
}

}  // namespace
}  // namespace sinew::wire::dronecan_udp_test
