#include "wire/mpu6050.hpp"

#include <gtest/gtest.h>

namespace sinew::wire::mpu6050::mpu6050_test {
namespace {

std::uint8_t written(const std::array<RegisterWrite, 9>& writes, std::uint8_t address) {
  int value = -1;
  for (const RegisterWrite& w : writes)
    if (w.address == address) value = w.value;
  EXPECT_GE(value, 0) << "register " << int{address} << " is never written";
  return static_cast<std::uint8_t>(value);
}

TEST(Mpu6050, ChipsAreKnownByTheirAnswer) {
  EXPECT_EQ(chip_of(0x68), Chip::mpu6050);
  EXPECT_EQ(chip_of(0x70), Chip::mpu6500);
  EXPECT_EQ(chip_of(0x71), Chip::mpu9250);
  EXPECT_EQ(chip_of(0x73), Chip::mpu9255);
  for (const int other : {0x00, 0xFF, 0x47, 0x69}) EXPECT_FALSE(chip_of(static_cast<std::uint8_t>(other)));
}

TEST(Mpu6050, SetUpWritesTheRegisterMapsBits) {
  const auto w = setup_writes({.accel_g = 8, .gyro_dps = 2000, .filter = 2, .rate_hz = 200}, Chip::mpu6050);
  ASSERT_TRUE(w);
  EXPECT_EQ(written(*w, kPower1), 0x01) << "awake, on the gyroscope's clock";
  EXPECT_EQ(written(*w, kSampleRateDivider), 4) << "1 kHz / (1 + 4)";
  EXPECT_EQ(written(*w, kConfig), 2);
  EXPECT_EQ(written(*w, kGyroConfig), 0x18);
  EXPECT_EQ(written(*w, kAccelConfig), 0x10);
  EXPECT_EQ(written(*w, kFifoEnable), 0x78);
  EXPECT_EQ(written(*w, kUserControl), 0x40);
}

TEST(Mpu6050, TheNewerChipsHaveASecondFilter) {
  const auto w = setup_writes({.filter = 3, .spi = true}, Chip::mpu9250);
  ASSERT_TRUE(w);
  EXPECT_EQ(written(*w, kAccelConfig2), 3);
  EXPECT_EQ(written(*w, kUserControl), 0x50);
  const auto old = setup_writes({.filter = 3}, Chip::mpu6050);
  for (const RegisterWrite& r : *old) EXPECT_NE(r.address, kAccelConfig2) << "reserved there";
}

TEST(Mpu6050, WhatTheChipCannotDoIsRefused) {
  EXPECT_FALSE(setup_writes({.accel_g = 3}, Chip::mpu6050));
  EXPECT_FALSE(setup_writes({.accel_g = 32}, Chip::mpu6050));
  EXPECT_FALSE(setup_writes({.gyro_dps = 4000}, Chip::mpu6050));
  EXPECT_FALSE(setup_writes({.filter = 0}, Chip::mpu6050));
  EXPECT_FALSE(setup_writes({.filter = 7}, Chip::mpu6050));
  EXPECT_FALSE(setup_writes({.rate_hz = 3}, Chip::mpu6050)) << "the divider has eight bits";
  EXPECT_FALSE(setup_writes({.rate_hz = 300}, Chip::mpu6050)) << "no whole divider";
  EXPECT_FALSE(setup_writes({.rate_hz = 0}, Chip::mpu6050));
}

TEST(Mpu6050, ABurstIsAccelTemperatureGyroBigEndian) {
  const std::array<std::uint8_t, kBurst> b{0x10, 0x00, 0xF0, 0x00, 0x00, 0x01, 0,
                                           0,    0x00, 0x83, 0xFF, 0x7D, 0x80, 0x00};
  const Sample s = decode_burst(b);
  EXPECT_EQ(s.accel, (std::array<std::int16_t, 3>{4096, -4096, 1}));
  EXPECT_EQ(s.gyro, (std::array<std::int16_t, 3>{131, -131, -32768}));
  const msg::Vec3 a = accel_mps2(s, {.accel_g = 8});
  EXPECT_DOUBLE_EQ(a.x, 9.80665) << "4096 counts per g at 8 g";
  const msg::Vec3 g = gyro_radps(s, {.gyro_dps = 250});
  EXPECT_NEAR(g.x, 0.0174532925, 1e-10) << "131 counts per degree per second at 250";
  EXPECT_NEAR(gyro_radps(s, {.gyro_dps = 2000}).x, 8 * 0.0174532925, 1e-9);
}

TEST(Mpu6050, APacketOfTheFifoHasNoTemperature) {
  const std::array<std::uint8_t, kPacket> p{0, 1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6};
  EXPECT_EQ(decode_packet(p), (Sample{{1, 2, 3}, {4, 5, 6}}));
}

TEST(Mpu6050, TemperatureFollowsTheChip) {
  std::array<std::uint8_t, kBurst> b{};
  EXPECT_DOUBLE_EQ(temperature_c(b, Chip::mpu6050), 36.53);
  EXPECT_DOUBLE_EQ(temperature_c(b, Chip::mpu6500), 21.0);
  b[6] = 0xFE, b[7] = 0xAC;  // -340
  EXPECT_DOUBLE_EQ(temperature_c(b, Chip::mpu6050), 35.53);
}

}  // namespace
}  // namespace sinew::wire::mpu6050::mpu6050_test
