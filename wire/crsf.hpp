#pragma once
// CRSF of TBS Crossfire and ExpressLRS receivers: 420000 bit/s 8N1. Only the channels are numbers of more than a byte,
// packed with the lowest bit first (rc_channels.hpp).
// Source:  TBS "CRSF protocol specification" rev 11: frame format, 0x14 link statistics, 0x16 channels.
#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "wire/frame_scanner.hpp"
#include "wire/rc_channels.hpp"

namespace sinew::wire {

/// Address (0xC8 flight controller; 0xEA, 0xEE, 0xEC others), length of what follows, type, payload, CRC-8 (0xD5) over
/// type and payload.
struct CrsfFormat {
  static constexpr std::size_t kMaxFrame = 64;
  static FrameVerdict check(std::span<const std::uint8_t> bytes) noexcept;
};
using CrsfScanner = FrameScanner<CrsfFormat>;

std::uint8_t crsf_crc(std::span<const std::uint8_t> bytes) noexcept;

struct CrsfLink {
  double rssi_dbm = 0;      // of the better antenna
  double link_quality = 0;  // 0..1
  double snr_db = 0;
};
/// Of a whole frame; nothing: another kind.
std::optional<RcCounts> decode_crsf_channels(std::span<const std::uint8_t> frame) noexcept;
std::optional<CrsfLink> decode_crsf_link(std::span<const std::uint8_t> frame) noexcept;

/// For simulated receivers.
std::array<std::uint8_t, 26> encode_crsf_channels(const RcCounts& counts) noexcept;
std::array<std::uint8_t, 14> encode_crsf_link(const CrsfLink& link) noexcept;

}  // namespace sinew::wire
