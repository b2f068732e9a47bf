#pragma once
// A CAN frame from fuzzed bytes, and the rules for every decoder.
#include <cstdlib>
#include <cstring>

#include "msg/can.hpp"

namespace sinew::wire {

/// u32 identifier, u8 flags, u8 size, data; missing bytes are 0.
inline msg::CanFrame fuzz_frame(const std::uint8_t* data, std::size_t size) {
  msg::CanFrame frame;
  if (size >= 4) std::memcpy(&frame.id, data, 4);
  if (size >= 5) frame.flags = data[4] & 31u;
  if (size >= 6) frame.size = data[5];  // also more than there is room for
  if (size > 6) std::memcpy(frame.data.data(), data + 6, size - 6 < 64 ? size - 6 : 64);
  return frame;
}
inline void must(bool holds) {
  if (!holds) std::abort();
}
inline bool same_bytes(const msg::CanFrame& a, const msg::CanFrame& b) {
  return a.id == b.id && a.size == b.size && a.extended() == b.extended() &&
         std::memcmp(a.data.data(), b.data.data(), a.size) == 0;
}

}  // namespace sinew::wire
