#include "wire/dronecan_udp.hpp"

#include <algorithm>

#include "wire/can_check.hpp"
#include "wire/crc_ccitt.hpp"

namespace sinew::wire {
namespace {

constexpr std::uint16_t kMagic = 0x2934, kFlagFd = 1;
constexpr std::uint32_t kIdExtended = 0x80000000;
constexpr std::size_t kAfterCrc = 4;

void put16(std::uint8_t* at, std::uint32_t value) {
  at[0] = static_cast<std::uint8_t>(value), at[1] = static_cast<std::uint8_t>(value >> 8);
}
std::uint16_t get16(const std::uint8_t* at) { return static_cast<std::uint16_t>(at[0] | (at[1] << 8)); }

}  // namespace

std::size_t dronecan_udp_encode(const msg::CanFrame& frame, std::span<std::uint8_t> out) noexcept {
  if (!is_can_frame(frame) || frame.remote() || out.size() < kDronecanUdpHead + frame.size) return 0;
  const std::uint32_t id = frame.id | (frame.extended() ? kIdExtended : 0);
  put16(&out[0], kMagic);
  put16(&out[4], frame.fd() ? kFlagFd : 0);
  put16(&out[6], id), put16(&out[8], id >> 16);
  std::copy_n(frame.data.begin(), frame.size, out.begin() + kDronecanUdpHead);
  const std::size_t size = kDronecanUdpHead + frame.size;
  put16(&out[2], crc_ccitt(out.first(size).subspan(kAfterCrc)));
  return size;
}

bool dronecan_udp_decode(std::span<const std::uint8_t> datagram, msg::CanFrame& out) noexcept {
  if (datagram.size() < kDronecanUdpHead || datagram.size() > kDronecanUdpMax) return false;
  if (get16(&datagram[0]) != kMagic || get16(&datagram[2]) != crc_ccitt(datagram.subspan(kAfterCrc))) return false;
  const std::uint32_t id = get16(&datagram[6]) | (static_cast<std::uint32_t>(get16(&datagram[8])) << 16);
  msg::CanFrame frame;
  frame.stamp = out.stamp, frame.bus = out.bus;
  frame.id = id & ~kIdExtended;
  frame.flags =
      ((id & kIdExtended) != 0 ? msg::kCanExtended : 0u) | ((get16(&datagram[4]) & kFlagFd) != 0 ? msg::kCanFd : 0u);
  frame.size = static_cast<std::uint32_t>(datagram.size() - kDronecanUdpHead);
  if (!is_can_frame(frame)) return false;
  std::copy(datagram.begin() + kDronecanUdpHead, datagram.end(), frame.data.begin());
  out = frame;
  return true;
}

}  // namespace sinew::wire
