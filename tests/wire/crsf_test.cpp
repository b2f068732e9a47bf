#include "wire/crsf.hpp"

#include <gtest/gtest.h>

#include "bytes.hpp"

namespace sinew::wire::crsf_test {
namespace {

using test::Bytes, test::bytes_of, test::frames_in, test::joined;

const Bytes kMiddle{0xC8, 0x18, 0x16, 0xE0, 0x03, 0x1F, 0xF8, 0xC0, 0x07, 0x3E, 0xF0, 0x81, 0x0F,
                    0x7C, 0xE0, 0x03, 0x1F, 0xF8, 0xC0, 0x07, 0x3E, 0xF0, 0x81, 0x0F, 0x7C, 0xAD};

TEST(Crsf, TheChecksumIsDvbS2) {
  EXPECT_EQ(crsf_crc(bytes_of("123456789")), 0xBC);  // check value of CRC-8/DVB-S2
}

TEST(Crsf, ChannelsAreUnpacked) {
  CrsfScanner scanner;
  const auto frames = frames_in(scanner, kMiddle);
  ASSERT_EQ(frames.size(), 1u);
  const auto counts = decode_crsf_channels(frames[0]);
  ASSERT_TRUE(counts);
  for (const std::uint16_t c : *counts) EXPECT_EQ(c, 992);
  EXPECT_FALSE(decode_crsf_link(frames[0]));
}

TEST(Crsf, LinkStatisticsTellQualityAndStrength) {
  Bytes f{0xC8, 12, 0x14, 95, 80, 97, static_cast<std::uint8_t>(-5), 0, 4, 2, 60, 100, 7};
  f.push_back(crsf_crc(std::span(f).subspan(2)));
  CrsfScanner scanner;
  const auto frames = frames_in(scanner, f);
  ASSERT_EQ(frames.size(), 1u);
  const auto link = decode_crsf_link(frames[0]);
  ASSERT_TRUE(link);
  EXPECT_DOUBLE_EQ(link->rssi_dbm, -80) << "of the better antenna";
  EXPECT_DOUBLE_EQ(link->link_quality, 0.97);
  EXPECT_DOUBLE_EQ(link->snr_db, -5);
  EXPECT_FALSE(decode_crsf_channels(frames[0]));
}

TEST(Crsf, OneAntennaIsEnough) {
  const auto f = encode_crsf_link({.rssi_dbm = -100, .link_quality = 0.5, .snr_db = 3});
  EXPECT_DOUBLE_EQ(decode_crsf_link(f)->rssi_dbm, -100);
}

TEST(Crsf, AFlippedBitAnywhereIsNoFrameAndTheNextOneIs) {
  for (std::size_t bit = 0; bit < kMiddle.size() * 8; ++bit) {
    Bytes bad = kMiddle;
    bad[bit / 8] = static_cast<std::uint8_t>(bad[bit / 8] ^ 1u << (bit % 8));
    CrsfScanner scanner;
    auto frames = frames_in(scanner, joined({bad, kMiddle, kMiddle, Bytes(64)}));
    // The address is not under the checksum: one of ours may turn into another one's.
    if (!frames.empty() && frames[0] == bad && bit < 8) frames.erase(frames.begin());
    EXPECT_EQ(frames, (std::vector<Bytes>{kMiddle, kMiddle})) << "bit " << bit;
  }
}

TEST(Crsf, WhatIsEncodedIsDecoded) {
  RcCounts counts{};
  for (std::size_t i = 0; i < counts.size(); ++i) counts[i] = static_cast<std::uint16_t>(172 + 100 * i);
  EXPECT_EQ(decode_crsf_channels(encode_crsf_channels(counts)), counts);
}

}  // namespace
}  // namespace sinew::wire::crsf_test
