#include "wire/sbus.hpp"

namespace sinew::wire {
namespace {
constexpr std::uint8_t kSbusHead = 0x0F;
}

FrameVerdict SbusFormat::check(std::span<const std::uint8_t> bytes) noexcept {
  if (bytes[0] != kSbusHead) return {FrameVerdict::foreign};
  if (bytes.size() < kMaxFrame) return {FrameVerdict::more};
  const std::uint8_t flags = bytes[23], end = bytes[24];
  const bool right = flags < 0x10 && (end == 0x00 || ((end & 0x0F) == 0x04 && end < 0x40));
  return {right ? FrameVerdict::good : FrameVerdict::broken, kMaxFrame};
}

SbusFrame SbusScanner::decode(std::span<const std::uint8_t> bytes) noexcept {
  const std::uint8_t flags = bytes[23];
  return {unpack_rc(bytes.subspan<1, kRcBytes>()), (flags & 1) != 0, (flags & 2) != 0, (flags & 4) != 0,
          (flags & 8) != 0};
}

std::array<std::uint8_t, 25> encode_sbus(const SbusFrame& frame) noexcept {
  std::array<std::uint8_t, 25> out{};
  out[0] = kSbusHead;
  pack_rc(frame.channel, std::span(out).subspan<1, kRcBytes>());
  out[23] = static_cast<std::uint8_t>((frame.channel_17 ? 1 : 0) | (frame.channel_18 ? 2 : 0) |
                                      (frame.frame_lost ? 4 : 0) | (frame.failsafe ? 8 : 0));
  return out;
}

}  // namespace sinew::wire
