#pragma once
#include <cstdint>
#include <span>

namespace sinew::wire {

inline constexpr std::uint16_t kCrcCcittStart = 0xFFFF;

/// CRC-16/CCITT-FALSE (polynomial 0x1021, most significant bit first, start 0xFFFF), continued from `crc`. RT: yes.
/// Source:  ITU-T V.41 polynomial; start value as DroneCAN's transfer CRC and its UDP framing use it. Check value of
///          "123456789": 0x29B1.
constexpr std::uint16_t crc_ccitt(std::span<const std::uint8_t> bytes, std::uint16_t crc = kCrcCcittStart) noexcept {
  for (const std::uint8_t byte : bytes) {
    crc = static_cast<std::uint16_t>(crc ^ (byte << 8));
    for (int bit = 0; bit < 8; ++bit)
      crc = static_cast<std::uint16_t>((crc & 0x8000) != 0 ? (crc << 1) ^ 0x1021 : crc << 1);
  }
  return crc;
}

}  // namespace sinew::wire
