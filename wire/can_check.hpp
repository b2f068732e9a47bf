#pragma once
#include "msg/can.hpp"

namespace sinew::wire {

inline constexpr std::uint32_t kCanStandardMask = 0x7FF, kCanExtendedMask = 0x1FFFFFFF;

/// Whether a CAN FD frame can have this many bytes of data. Source: ISO 11898-1:2015, table 5 (DLC).
constexpr bool is_can_fd_size(std::size_t size) noexcept {
  return size <= 8 || size == 12 || size == 16 || size == 20 || size == 24 || size == 32 || size == 48 || size == 64;
}

/// Whether such a frame can exist on a bus: identifier and size fit its flags; a remote frame has no data. False for
/// error frames.   RT: yes.
inline bool is_can_frame(const msg::CanFrame& frame) noexcept {
  if (frame.error() || frame.id > (frame.extended() ? kCanExtendedMask : kCanStandardMask)) return false;
  if (frame.fd()) return !frame.remote() && is_can_fd_size(frame.size);
  return frame.size <= 8 && (frame.flags & msg::kCanBitRateSwitch) == 0;
}

}  // namespace sinew::wire
