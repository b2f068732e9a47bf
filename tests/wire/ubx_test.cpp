#include "wire/ubx.hpp"

#include <gtest/gtest.h>

#include "bytes.hpp"

namespace sinew::wire::ubx_test {
namespace {

using test::Bytes, test::frames_in, test::joined;

Bytes encoded(std::size_t size, const std::array<std::uint8_t, 256>& out) {
  return {out.begin(), out.begin() + static_cast<std::ptrdiff_t>(size)};
}

UbxPvt sample_pvt() {
  UbxPvt p{.time_of_week_ms = 123456789,
           .year = 2026,
           .month = 3,
           .day = 31,
           .hour = 23,
           .minute = 59,
           .second = 58,
           .date_valid = true,
           .time_valid = true,
           .sample = {}};
  p.sample.latitude_deg = -33.8567844;
  p.sample.longitude_deg = 151.2152967;
  p.sample.altitude_m = -1.234;
  p.sample.velocity_mps = {1.5, -2.25, 0.75};
  p.sample.horizontal_accuracy_m = 1.2, p.sample.vertical_accuracy_m = 2.3, p.sample.speed_accuracy_mps = 0.12;
  p.sample.fix = msg::GnssFix::full;
  p.sample.satellites = 17;
  return p;
}

Bytes pvt_frame(const UbxPvt& p) {
  std::array<std::uint8_t, 256> out{};
  return encoded(encode_nav_pvt(p, out), out);
}

TEST(Ubx, TheReceiverIsAskedInTheMakersBytes) {
  std::array<std::uint8_t, 256> out{};
  // Frames that u-center sends for the same.
  EXPECT_EQ(encoded(encode_enable_nav_pvt(out), out), (Bytes{0xB5, 0x62, 6, 1, 3, 0, 1, 7, 1, 0x13, 0x51}));
  EXPECT_EQ(encoded(encode_solution_rate(100, out), out),
            (Bytes{0xB5, 0x62, 6, 8, 6, 0, 0x64, 0, 1, 0, 1, 0, 0x7A, 0x12}));
}

TEST(Ubx, FieldsOfNavPvtStandWhereTheManualHasThem) {
  Bytes payload(92);
  const auto put = [&](std::size_t at, std::uint32_t value) {
    for (std::size_t i = 0; i < 4; ++i) payload[at + i] = static_cast<std::uint8_t>(value >> (8 * i));
  };
  payload[20] = 3, payload[21] = 0x83, payload[23] = 21;
  put(24, 85000000), put(28, 475000000), put(32, 999999), put(36, 450123);
  put(40, 14), put(44, 25), put(48, 1000), put(52, 2000), put(56, static_cast<std::uint32_t>(-300)), put(68, 42);
  std::array<std::uint8_t, 256> out{};
  const auto pvt = decode_nav_pvt(encoded(encode_ubx(1, 7, payload, out), out));
  ASSERT_TRUE(pvt);
  const msg::GnssSample& s = pvt->sample;
  EXPECT_DOUBLE_EQ(s.longitude_deg, 8.5);
  EXPECT_DOUBLE_EQ(s.latitude_deg, 47.5);
  EXPECT_DOUBLE_EQ(s.altitude_m, 450.123) << "above mean sea level, not above the ellipsoid";
  EXPECT_DOUBLE_EQ(s.horizontal_accuracy_m, 0.014);
  EXPECT_DOUBLE_EQ(s.vertical_accuracy_m, 0.025);
  EXPECT_DOUBLE_EQ(s.velocity_mps.x, 2.0) << "east";
  EXPECT_DOUBLE_EQ(s.velocity_mps.y, 1.0) << "north";
  EXPECT_DOUBLE_EQ(s.velocity_mps.z, 0.3) << "up";
  EXPECT_DOUBLE_EQ(s.speed_accuracy_mps, 0.042);
  EXPECT_EQ(s.fix, msg::GnssFix::rtk_fixed);
  EXPECT_EQ(s.satellites, 21u);
}

TEST(Ubx, WhatIsEncodedIsDecoded) {
  const UbxPvt p = sample_pvt();
  UbxScanner scanner;
  const auto frames = frames_in(scanner, pvt_frame(p));
  ASSERT_EQ(frames.size(), 1u);
  const auto q = decode_nav_pvt(frames[0]);
  ASSERT_TRUE(q);
  EXPECT_NEAR(q->sample.latitude_deg, p.sample.latitude_deg, 1e-7);
  EXPECT_NEAR(q->sample.longitude_deg, p.sample.longitude_deg, 1e-7);
  EXPECT_NEAR(q->sample.altitude_m, p.sample.altitude_m, 1e-9);
  EXPECT_EQ(q->sample.velocity_mps, p.sample.velocity_mps);
  EXPECT_EQ(q->sample.fix, p.sample.fix);
  EXPECT_EQ(q->year, 2026);
  EXPECT_EQ(q->second, 58);
}

TEST(Ubx, AFixWithoutItsFlagIsNone) {
  for (const auto fix : {msg::GnssFix::none, msg::GnssFix::time, msg::GnssFix::flat, msg::GnssFix::full,
                         msg::GnssFix::rtk_float, msg::GnssFix::rtk_fixed}) {
    UbxPvt p = sample_pvt();
    p.sample.fix = fix;
    EXPECT_EQ(decode_nav_pvt(pvt_frame(p))->sample.fix, fix);
  }
  Bytes payload(92);
  payload[20] = 3;  // three-dimensional, but not within the receiver's own limits
  std::array<std::uint8_t, 256> out{};
  EXPECT_EQ(decode_nav_pvt(encoded(encode_ubx(1, 7, payload, out), out))->sample.fix, msg::GnssFix::none);
}

TEST(Ubx, ShortOrOtherMessagesAreNotNavPvt) {
  std::array<std::uint8_t, 256> out{};
  EXPECT_FALSE(decode_nav_pvt(encoded(encode_ubx(1, 7, Bytes(83), out), out)));
  EXPECT_FALSE(decode_nav_pvt(encoded(encode_ubx(1, 6, Bytes(92), out), out)));
}

TEST(Ubx, AFlippedBitAnywhereIsNoFrameAndTheNextOneIs) {
  const Bytes good = pvt_frame(sample_pvt());
  for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
    Bytes bad = good;
    bad[bit / 8] = static_cast<std::uint8_t>(bad[bit / 8] ^ 1u << (bit % 8));
    UbxScanner scanner;
    // A wrong length may wait for more than one frame's bytes: the good frames are found late, but they are found.
    EXPECT_EQ(frames_in(scanner, joined({bad, good, good, good, Bytes(256)})), (std::vector<Bytes>{good, good, good}))
        << "bit " << bit;
  }
}

TEST(Ubx, LongMessagesArePassedOver) {
  UbxScanner scanner;
  Bytes head{0xB5, 0x62, 0x02, 0x15, 0x00, 0x04};
  const Bytes good = pvt_frame(sample_pvt());
  EXPECT_EQ(frames_in(scanner, joined({head, Bytes(1024, 0x11), good})), std::vector<Bytes>{good});
}

}  // namespace
}  // namespace sinew::wire::ubx_test
