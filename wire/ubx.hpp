#pragma once
// u-blox receivers' binary protocol: framing, NAV-PVT, and the two messages that switch it on. All little endian.
// Source:  u-blox UBX-13003221 (M8) section 32: 32.2 framing, 32.4 checksum, 32.17.15 NAV-PVT, 32.10.18 CFG-MSG,
//          32.10.27 CFG-RATE; the same in UBX-18010854 (F9).
#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "msg/geometry.hpp"
#include "msg/sensors.hpp"
#include "wire/frame_scanner.hpp"

namespace sinew::wire {

/// 0xB5 0x62, class, identity, length (little endian), payload, Fletcher-8 checksum over all between.
struct UbxFormat {
  static constexpr std::size_t kMaxFrame = 256;  // longer ones (raw measurements) are passed over
  static FrameVerdict check(std::span<const std::uint8_t> bytes) noexcept;
};
using UbxScanner = FrameScanner<UbxFormat>;

inline constexpr std::size_t kUbxOverhead = 8;
constexpr std::uint8_t ubx_class(std::span<const std::uint8_t> frame) { return frame[2]; }
constexpr std::uint8_t ubx_id(std::span<const std::uint8_t> frame) { return frame[3]; }
inline std::span<const std::uint8_t> ubx_payload(std::span<const std::uint8_t> frame) {
  return frame.subspan(6, frame.size() - kUbxOverhead);
}

struct UbxPvt {
  std::uint32_t time_of_week_ms = 0;
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, second = 0;
  bool date_valid = false, time_valid = false;
  msg::GnssSample sample;  // everything but its stamp
};
/// Of a whole frame; nothing: another message, or one shorter than any version of it.
std::optional<UbxPvt> decode_nav_pvt(std::span<const std::uint8_t> frame) noexcept;

/// Writes a frame; how long it is, 0 when it does not fit.
std::size_t encode_ubx(std::uint8_t message_class, std::uint8_t id, std::span<const std::uint8_t> payload,
                       std::span<std::uint8_t> out) noexcept;
/// NAV-PVT with each solution on the port that this comes in by.
std::size_t encode_enable_nav_pvt(std::span<std::uint8_t> out) noexcept;
/// A solution every `period_ms`.
std::size_t encode_solution_rate(std::uint16_t period_ms, std::span<std::uint8_t> out) noexcept;
/// For simulated receivers.
std::size_t encode_nav_pvt(const UbxPvt& pvt, std::span<std::uint8_t> out) noexcept;

}  // namespace sinew::wire
