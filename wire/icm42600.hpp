#pragma once
// Registers (bank 0) and FIFO packets of the ICM-426xx family: ICM-42605, -42688-P and their sisters.
// Source:  TDK DS-000347 rev 1.6 (ICM-42688-P) sections 4, 6 and 14; identities as in Linux
//          drivers/iio/imu/inv_icm42600/inv_icm42600.h.
#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "msg/geometry.hpp"
#include "wire/sensor_bytes.hpp"

namespace sinew::wire::icm42600 {

inline constexpr std::uint8_t kDeviceConfig = 0x11, kFifoConfig = 0x16, kTemperature = 0x1D, kIntStatus = 0x2D,
                              kFifoCount = 0x2E, kFifoData = 0x30, kSignalPathReset = 0x4B, kInterface0 = 0x4C,
                              kPower0 = 0x4E, kGyroConfig0 = 0x4F, kAccelConfig0 = 0x50, kFilter0 = 0x52,
                              kFifoConfig1 = 0x5F, kWhoAmI = 0x75, kBank = 0x76;
inline constexpr std::uint8_t kSoftReset = 0x01;                                       // in kDeviceConfig
inline constexpr std::uint8_t kResetDone = 0x10, kDataReady = 0x08, kFifoFull = 0x02;  // in kIntStatus
inline constexpr std::uint8_t kFifoFlush = 0x02;                                       // in kSignalPathReset
inline constexpr std::size_t kBurst = 14;   // temperature, accel, gyro from kTemperature on; big endian
inline constexpr std::size_t kPacket = 16;  // header, accel, gyro, temperature, time
inline constexpr std::size_t kFifoBytes = 2048;

/// The name of the chip with that identity; null: no chip of this family.
const char* name_of(std::uint8_t who_am_i) noexcept;

struct Setup {
  int accel_g = 8;      // 2, 4, 8, 16
  int gyro_dps = 2000;  // 250, 500, 1000, 2000
  int rate_hz = 1000;   // 8000, 4000, 2000, 1000, 500, 200, 100, 50, 25
  bool fifo = true;
};
/// The register writes after a reset, in this order; nothing when the chip does not have this set-up.
std::optional<std::array<RegisterWrite, 8>> setup_writes(const Setup& setup) noexcept;

/// A sample in the chip's axes.
struct Sample {
  std::array<std::int16_t, 3> accel{}, gyro{};
  friend bool operator==(const Sample&, const Sample&) = default;
};
/// False where the chip has no value yet (all -32768).
bool is_valid(const Sample& sample) noexcept;
Sample decode_burst(std::span<const std::uint8_t, kBurst> bytes) noexcept;
double temperature_c(std::span<const std::uint8_t, kBurst> bytes) noexcept;
/// Nothing: not a packet with both sensors (its header says that the FIFO is empty, or of another kind).
std::optional<Sample> decode_packet(std::span<const std::uint8_t, kPacket> bytes) noexcept;
msg::Vec3 accel_mps2(const Sample& sample, const Setup& setup) noexcept;
msg::Vec3 gyro_radps(const Sample& sample, const Setup& setup) noexcept;

}  // namespace sinew::wire::icm42600
