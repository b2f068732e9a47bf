#include "wire/bmp280.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace sinew::wire::bmp280::bmp280_test {
namespace {

/// The chip of the datasheet's example, section 3.12.
std::array<std::uint8_t, kCalibrationBytes> example() {
  constexpr int kWords[] = {27504, 26435, -1000, 36477, -10685, 3024, 2855, 140, -7, 15500, -14600, 6000};
  std::array<std::uint8_t, kCalibrationBytes> bytes{};
  for (std::size_t i = 0; i < 12; ++i) {
    const auto word = static_cast<std::uint16_t>(kWords[i]);
    bytes[2 * i] = static_cast<std::uint8_t>(word), bytes[2 * i + 1] = static_cast<std::uint8_t>(word >> 8);
  }
  return bytes;
}

TEST(Bmp280, TheDatasheetsExampleComesOut) {
  const auto calibration = decode_calibration(example());
  ASSERT_TRUE(calibration);
  const Reading r = compensate({.pressure = 415148, .temperature = 519888}, *calibration);
  EXPECT_NEAR(r.temperature_c, 25.08, 0.005);
  EXPECT_NEAR(r.pressure_pa, 100653.27, 0.02);
}

TEST(Bmp280, TwentyBitsArePutTogether) {
  EXPECT_EQ(decode_burst(std::array<std::uint8_t, kBurst>{0x65, 0x5A, 0xC0, 0x7E, 0xED, 0x00}), (Raw{415148, 519888}));
}

TEST(Bmp280, ABusHeldLowOrHighIsNoCalibration) {
  std::array<std::uint8_t, kCalibrationBytes> bytes{};
  EXPECT_FALSE(decode_calibration(bytes));
  bytes.fill(0xFF);
  EXPECT_FALSE(decode_calibration(bytes));
}

TEST(Bmp280, ResetValuesAreNoMeasurement) {
  EXPECT_FALSE(is_measured(decode_burst(std::array<std::uint8_t, kBurst>{0x80, 0, 0, 0x80, 0, 0})));
  EXPECT_TRUE(is_measured({415148, 519888}));
}

TEST(Bmp280, ACalibrationThatDividesByZeroIsNotANumber) {
  Calibration c{};
  c.t1 = 1;
  EXPECT_TRUE(std::isnan(compensate({1, 1}, c).pressure_pa));
}

TEST(Bmp280, ChipsAreKnownByTheirAnswer) {
  EXPECT_STREQ(name_of(0x58), "BMP280");
  EXPECT_STREQ(name_of(0x60), "BME280");
  EXPECT_EQ(name_of(0x55), nullptr) << "a BMP180";
}

}  // namespace
}  // namespace sinew::wire::bmp280::bmp280_test
