#include "wire/icm42600.hpp"

#include <gtest/gtest.h>

namespace sinew::wire::icm42600::icm42600_test {
namespace {

std::uint8_t written(const std::array<RegisterWrite, 8>& writes, std::uint8_t address) {
  for (const RegisterWrite& w : writes)
    if (w.address == address) return w.value;
  ADD_FAILURE() << "register " << int{address} << " is never written";
  return 0;
}

TEST(Icm42600, ChipsAreKnownByTheirAnswer) {
  EXPECT_STREQ(name_of(0x47), "ICM-42688");
  EXPECT_STREQ(name_of(0x42), "ICM-42605");
  EXPECT_EQ(name_of(0x68), nullptr);
  EXPECT_EQ(name_of(0x00), nullptr);
  EXPECT_EQ(name_of(0xFF), nullptr);
}

TEST(Icm42600, SetUpWritesTheRegisterMapsBits) {
  const auto w = setup_writes({.accel_g = 4, .gyro_dps = 500, .rate_hz = 500});
  ASSERT_TRUE(w);
  EXPECT_EQ(written(*w, kGyroConfig0), 0x4F) << "010: 500 deg/s; 1111: 500 Hz";
  EXPECT_EQ(written(*w, kAccelConfig0), 0x4F) << "010: 4 g";
  EXPECT_EQ(written(*w, kPower0), 0x0F);
  EXPECT_EQ(written(*w, kFifoConfig), 0x40);
  EXPECT_EQ(written(*w, kFifoConfig1), 0x07);
  EXPECT_EQ(w->back().address, kPower0) << "the sensors start when all else is set";
  EXPECT_EQ(written(*setup_writes({.fifo = false}), kFifoConfig1), 0);
}

TEST(Icm42600, WhatTheChipCannotDoIsRefused) {
  EXPECT_FALSE(setup_writes({.accel_g = 32}));
  EXPECT_FALSE(setup_writes({.gyro_dps = 300}));
  EXPECT_FALSE(setup_writes({.rate_hz = 400}));
}

TEST(Icm42600, ABurstIsTemperatureAccelGyroBigEndian) {
  const std::array<std::uint8_t, kBurst> b{0x00, 0x84, 0x20, 0x00, 0, 1, 0, 2, 0x00, 0x83, 0, 3, 0xFF, 0xFF};
  const Sample s = decode_burst(b);
  EXPECT_EQ(s, (Sample{{8192, 1, 2}, {131, 3, -1}}));
  EXPECT_NEAR(temperature_c(b), 25 + 132 / 132.48, 1e-12);
  EXPECT_DOUBLE_EQ(accel_mps2(s, {.accel_g = 4}).x, 9.80665) << "8192 counts per g at 4 g";
  EXPECT_NEAR(gyro_radps(s, {.gyro_dps = 250}).x, 0.0174532925, 1e-10);
}

TEST(Icm42600, APacketSaysInItsHeaderWhatItHolds) {
  std::array<std::uint8_t, kPacket> p{0x68, 0, 1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0, 0, 0};
  ASSERT_TRUE(decode_packet(p));
  EXPECT_EQ(*decode_packet(p), (Sample{{1, 2, 3}, {4, 5, 6}}));
  for (const int header : {0x80, 0x00, 0x40, 0x20, 0x78, 0xFF}) {
    p[0] = static_cast<std::uint8_t>(header);
    EXPECT_FALSE(decode_packet(p)) << header;
  }
}

TEST(Icm42600, ASensorThatHasNotStartedIsNoMeasurement) {
  EXPECT_FALSE(is_valid({{-32768, -32768, -32768}, {1, 2, 3}}));
  EXPECT_FALSE(is_valid({{1, 2, 3}, {-32768, -32768, -32768}}));
  EXPECT_TRUE(is_valid({{-32768, 0, 0}, {0, 0, 0}})) << "one axis may be at its end";
}

}  // namespace
}  // namespace sinew::wire::icm42600::icm42600_test
