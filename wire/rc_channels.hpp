#pragma once
// Sixteen channels of 11 bits, packed with the lowest bit first: SBUS and CRSF carry the same 22 bytes.
#include <array>
#include <cstdint>
#include <span>

namespace sinew::wire {

inline constexpr std::size_t kRcBytes = 22;
using RcCounts = std::array<std::uint16_t, 16>;

RcCounts unpack_rc(std::span<const std::uint8_t, kRcBytes> bytes) noexcept;
void pack_rc(const RcCounts& counts, std::span<std::uint8_t, kRcBytes> out) noexcept;

// Sticks go from 172 (988 us, -1) over 992 (1500 us, 0) to 1811 (2012 us, 1). SBUS transmitters send the same numbers
// at +-100 %. Source: TBS CRSF specification rev 11, "Broadcast Frame 0x16".
inline constexpr std::uint16_t kRcLow = 172, kRcMiddle = 992, kRcHigh = 1811;
/// Clamped to -1.25..1.25: transmitters can send more than their sticks' full way.
double rc_stick(std::uint16_t count) noexcept;
std::uint16_t rc_count(double stick) noexcept;

}  // namespace sinew::wire
