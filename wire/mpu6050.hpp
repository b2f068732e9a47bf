#pragma once
// Registers of the MPU-6000/6050 and of the MPU-6500/9250/9255, which keep the same ones for what is used here.
// Source:  InvenSense RM-MPU-6000A-00 rev 4.2 (register map), PS-MPU-6000A-00 rev 3.4 (sensitivities);
//          RM-MPU-9250A-00 rev 1.6, RM-MPU-6500A-00 rev 2.1.
#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "msg/geometry.hpp"
#include "msg/time.hpp"
#include "wire/sensor_bytes.hpp"

namespace sinew::wire::mpu6050 {

inline constexpr std::uint8_t kSampleRateDivider = 0x19, kConfig = 0x1A, kGyroConfig = 0x1B, kAccelConfig = 0x1C,
                              kAccelConfig2 = 0x1D, kFifoEnable = 0x23, kIntEnable = 0x38, kIntStatus = 0x3A,
                              kAccelX = 0x3B, kUserControl = 0x6A, kPower1 = 0x6B, kPower2 = 0x6C, kFifoCount = 0x72,
                              kFifoData = 0x74, kWhoAmI = 0x75;
inline constexpr std::uint8_t kReset = 0x80, kClockGyro = 0x01;                   // in kPower1
inline constexpr std::uint8_t kFifoOn = 0x40, kI2cOff = 0x10, kFifoReset = 0x04;  // in kUserControl
inline constexpr std::uint8_t kFifoAccelGyro = 0x78;                              // in kFifoEnable
inline constexpr std::uint8_t kDataReady = 0x01, kFifoOverflow = 0x10;            // in kIntStatus
inline constexpr std::size_t kBurst = 14;   // accel, temperature, gyro from kAccelX on; big endian
inline constexpr std::size_t kPacket = 12;  // in the FIFO: accel, gyro

enum class Chip : std::uint8_t { mpu6050, mpu6500, mpu9250, mpu9255 };
/// By the answer of kWhoAmI; nothing: another chip.
std::optional<Chip> chip_of(std::uint8_t who_am_i) noexcept;
const char* to_string(Chip chip) noexcept;
/// Bytes that its FIFO holds.
constexpr std::size_t fifo_bytes(Chip chip) { return chip == Chip::mpu6050 ? 1024 : 512; }

/// Full scale, and the filter's choice of 0..6 (260, 184, 94, 44, 21, 10, 5 Hz on the MPU-6050).
struct Setup {
  int accel_g = 8;      // 2, 4, 8, 16
  int gyro_dps = 2000;  // 250, 500, 1000, 2000
  int filter = 2;       // 1..6: 1 kHz inside; 0 (8 kHz inside) is not offered
  int rate_hz = 1000;   // 1000 / (1 + n), n = 0..255
  bool fifo = true;
  bool spi = false;  // switches the I2C side off, so that it does not mistake SPI traffic for its own
};
/// The register writes after a reset, in this order; nothing when the chip does not have this set-up.
std::optional<std::array<RegisterWrite, 9>> setup_writes(const Setup& setup, Chip chip) noexcept;

/// The gyroscope's delay by the filter; the accelerometer's is within 0.2 ms of it. RM-MPU-6000A section 4.3.
msg::Duration filter_delay(int filter) noexcept;

/// A sample in the chip's axes.
struct Sample {
  std::array<std::int16_t, 3> accel{}, gyro{};
  friend bool operator==(const Sample&, const Sample&) = default;
};
Sample decode_burst(std::span<const std::uint8_t, kBurst> bytes) noexcept;
Sample decode_packet(std::span<const std::uint8_t, kPacket> bytes) noexcept;
/// Degrees Celsius in a burst (bytes 6 and 7).
double temperature_c(std::span<const std::uint8_t, kBurst> bytes, Chip chip) noexcept;
msg::Vec3 accel_mps2(const Sample& sample, const Setup& setup) noexcept;
msg::Vec3 gyro_radps(const Sample& sample, const Setup& setup) noexcept;

}  // namespace sinew::wire::mpu6050
