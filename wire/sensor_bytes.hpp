#pragma once
// Integers in the registers and frames of sensors.
#include <cstdint>

namespace sinew::wire {

constexpr std::uint16_t be16(const std::uint8_t* p) { return static_cast<std::uint16_t>(p[0] << 8 | p[1]); }
constexpr std::uint16_t le16(const std::uint8_t* p) { return static_cast<std::uint16_t>(p[1] << 8 | p[0]); }
constexpr std::uint32_t le32(const std::uint8_t* p) {
  return static_cast<std::uint32_t>(p[3]) << 24 | static_cast<std::uint32_t>(p[2]) << 16 | le16(p);
}
constexpr std::int16_t be16s(const std::uint8_t* p) { return static_cast<std::int16_t>(be16(p)); }
constexpr std::int16_t le16s(const std::uint8_t* p) { return static_cast<std::int16_t>(le16(p)); }
constexpr std::int32_t le32s(const std::uint8_t* p) { return static_cast<std::int32_t>(le32(p)); }

inline constexpr double kRadPerDeg = 0.017453292519943295;
inline constexpr double kStandardGravity = 9.80665;  // m/s^2, by definition (CGPM 1901)

/// One register and what goes into it.
struct RegisterWrite {
  std::uint8_t address = 0, value = 0;
};

}  // namespace sinew::wire
