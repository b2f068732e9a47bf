#pragma once
// Registers of the BMP280 barometer (and of the BME280, which measures pressure in the same way), and the conversion of
// its numbers to pressure. The calibration is little-endian, measurements have their highest byte first.
// Source:  Bosch BST-BMP280-DS001 rev 1.26: memory map section 4, compensation section 3.11.3 and appendix 8.1.
#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "wire/sensor_bytes.hpp"

namespace sinew::wire::bmp280 {

inline constexpr std::uint8_t kCalibration = 0x88, kId = 0xD0, kReset = 0xE0, kStatus = 0xF3, kControl = 0xF4,
                              kConfig = 0xF5, kPressure = 0xF7;
inline constexpr std::uint8_t kResetWord = 0xB6, kCopying = 0x01;  // in kStatus: calibration is being copied
inline constexpr std::size_t kCalibrationBytes = 24, kBurst = 6;   // pressure and temperature from kPressure on

/// "BMP280", "BME280"; null: another chip.
const char* name_of(std::uint8_t id) noexcept;

/// The factory's trimming of one chip.
struct Calibration {
  std::uint16_t t1 = 0;
  std::int16_t t2 = 0, t3 = 0;
  std::uint16_t p1 = 0;
  std::array<std::int16_t, 8> p2_9{};
};
/// Nothing: it cannot be a chip's (p1 or t1 is 0, as from a bus that holds its lines low, or all bits are set).
std::optional<Calibration> decode_calibration(std::span<const std::uint8_t, kCalibrationBytes> bytes) noexcept;

/// Measures all the time: 16 x pressure, 2 x temperature, filter 4; a new value each 40 ms at least.
inline constexpr std::array<RegisterWrite, 2> kSetupWrites{{{kConfig, 0x08}, {kControl, 0x57}}};

struct Raw {
  std::int32_t pressure = 0, temperature = 0;  // 20 bits
  friend bool operator==(const Raw&, const Raw&) = default;
};
Raw decode_burst(std::span<const std::uint8_t, kBurst> bytes) noexcept;
/// False: the chip has not measured (its registers' reset values).
bool is_measured(const Raw& raw) noexcept;

struct Reading {
  double pressure_pa = 0, temperature_c = 0;
};
/// The pressure is NaN where the calibration makes it a division by zero.
Reading compensate(const Raw& raw, const Calibration& calibration) noexcept;

}  // namespace sinew::wire::bmp280
