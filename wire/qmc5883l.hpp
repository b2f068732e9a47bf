#pragma once
// Registers of the QMC5883L magnetometer (the chip on most GNSS modules and on boards sold as "HMC5883L" at 0x0D).
// Source:  QST 13-52-04 (QMC5883L datasheet) rev 1.0 section 9, sensitivity section 2.1.
#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "msg/geometry.hpp"
#include "wire/sensor_bytes.hpp"

namespace sinew::wire::qmc5883l {

inline constexpr std::uint8_t kAddress = 0x0D;  // on the bus, fixed
inline constexpr std::uint8_t kData = 0x00, kStatus = 0x06, kControl1 = 0x09, kControl2 = 0x0A, kSetReset = 0x0B,
                              kChipId = 0x0D;
inline constexpr std::uint8_t kChipIdValue = 0xFF, kSoftReset = 0x80;
inline constexpr std::uint8_t kReady = 0x01, kOverflow = 0x02;  // in kStatus
inline constexpr std::size_t kBurst = 7;                        // x, y, z (little endian) and status from kData on

struct Setup {
  int range_gauss = 8;  // 2, 8
  int rate_hz = 50;     // 10, 50, 100, 200
};
/// The register writes after a reset, in this order; nothing when the chip does not have this set-up.
std::optional<std::array<RegisterWrite, 3>> setup_writes(const Setup& setup) noexcept;

struct Sample {
  std::array<std::int16_t, 3> field{};
  bool ready = false, overflow = false;
};
Sample decode_burst(std::span<const std::uint8_t, kBurst> bytes) noexcept;
/// In the chip's axes.
msg::Vec3 field_t(const Sample& sample, const Setup& setup) noexcept;

}  // namespace sinew::wire::qmc5883l
