#include "wire/crsf.hpp"

#include <algorithm>
#include <cmath>

namespace sinew::wire {
namespace {

constexpr std::uint8_t kFlightController = 0xC8, kLink = 0x14, kChannels = 0x16;
constexpr std::size_t kLinkPayload = 10;

bool is_address(std::uint8_t b) { return b == kFlightController || b == 0xEA || b == 0xEC || b == 0xEE; }

template <std::size_t N>
void finish(std::array<std::uint8_t, N>& frame, std::uint8_t type) {
  frame[0] = kFlightController;
  frame[1] = static_cast<std::uint8_t>(N - 2);
  frame[2] = type;
  frame[N - 1] = crsf_crc(std::span<const std::uint8_t>(frame).subspan(2, N - 3));
}

}  // namespace

std::uint8_t crsf_crc(std::span<const std::uint8_t> bytes) noexcept {
  std::uint8_t crc = 0;
  for (const std::uint8_t byte : bytes) {
    crc ^= byte;
    for (int i = 0; i < 8; ++i) crc = static_cast<std::uint8_t>(crc & 0x80 ? crc << 1 ^ 0xD5 : crc << 1);
  }
  return crc;
}

FrameVerdict CrsfFormat::check(std::span<const std::uint8_t> bytes) noexcept {
  if (!is_address(bytes[0])) return {FrameVerdict::foreign};
  if (bytes.size() < 2) return {FrameVerdict::more};
  const std::size_t size = bytes[1] + 2u;
  if (size < 4 || size > kMaxFrame) return {FrameVerdict::foreign};
  if (bytes.size() < size) return {FrameVerdict::more};
  const bool right = crsf_crc(bytes.subspan(2, size - 3)) == bytes[size - 1];
  return {right ? FrameVerdict::good : FrameVerdict::broken, size};
}

std::optional<RcCounts> decode_crsf_channels(std::span<const std::uint8_t> frame) noexcept {
  if (frame.size() != kRcBytes + 4 || frame[2] != kChannels) return {};
  return unpack_rc(frame.subspan<3, kRcBytes>());
}

std::optional<CrsfLink> decode_crsf_link(std::span<const std::uint8_t> frame) noexcept {
  if (frame.size() < kLinkPayload + 4 || frame[2] != kLink) return {};
  const std::uint8_t* p = frame.data() + 3;
  // Antenna 2 says 0 where there is only one.
  const int weakness = p[1] != 0 ? std::min(p[0], p[1]) : p[0];
  return CrsfLink{-static_cast<double>(weakness), std::min<int>(p[2], 100) * 0.01,
                  static_cast<double>(static_cast<std::int8_t>(p[3]))};
}

std::array<std::uint8_t, 26> encode_crsf_channels(const RcCounts& counts) noexcept {
  std::array<std::uint8_t, 26> out{};
  pack_rc(counts, std::span(out).subspan<3, kRcBytes>());
  finish(out, kChannels);
  return out;
}

std::array<std::uint8_t, 14> encode_crsf_link(const CrsfLink& link) noexcept {
  std::array<std::uint8_t, 14> out{};
  out[3] = static_cast<std::uint8_t>(std::clamp(std::lround(-link.rssi_dbm), 0L, 255L));
  out[5] = static_cast<std::uint8_t>(std::clamp(std::lround(link.link_quality * 100), 0L, 100L));
  out[6] = static_cast<std::uint8_t>(static_cast<std::int8_t>(std::lround(link.snr_db)));
  finish(out, kLink);
  return out;
}

}  // namespace sinew::wire
