#pragma once
// Numbers in the data of a CAN frame; each function's name says the byte order. RT: yes. Reading checks bounds: a
// number outside of the data reads as 0, and the size tells.
#include <cstring>
#include <initializer_list>
#include <type_traits>

#include "msg/can.hpp"

namespace sinew::wire {

/// An empty classic frame.
inline msg::CanFrame can_frame(std::uint32_t id, std::uint32_t size, bool extended = false) {
  msg::CanFrame frame;
  frame.id = id;
  frame.size = size;
  frame.flags = extended ? std::uint32_t{msg::kCanExtended} : 0u;
  return frame;
}
inline msg::CanFrame can_frame(std::uint32_t id, std::initializer_list<std::uint8_t> bytes) {
  msg::CanFrame frame = can_frame(id, static_cast<std::uint32_t>(bytes.size()));
  std::size_t i = 0;
  for (const std::uint8_t b : bytes) frame.data[i++] = b;
  return frame;
}

/// A classic data frame with an identifier of this kind: every protocol of this room checks this first.
inline bool is_data(const msg::CanFrame& frame, bool extended) {
  return !frame.error() && !frame.remote() && !frame.fd() && frame.extended() == extended && frame.size <= 8;
}

template <class T>
void put_le(msg::CanFrame& frame, std::size_t at, T value) {
  static_assert(std::is_integral_v<T>);
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    frame.data[at + i] = static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> (8 * i));
  }
}
template <class T>
T get_le(const msg::CanFrame& frame, std::size_t at) {
  static_assert(std::is_integral_v<T>);
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) value |= static_cast<std::uint64_t>(frame.data[at + i]) << (8 * i);
  return static_cast<T>(value);
}
inline void put_be16(msg::CanFrame& frame, std::size_t at, std::uint32_t value) {
  frame.data[at] = static_cast<std::uint8_t>(value >> 8);
  frame.data[at + 1] = static_cast<std::uint8_t>(value);
}
inline std::uint32_t get_be16(const msg::CanFrame& frame, std::size_t at) {
  return static_cast<std::uint32_t>(frame.data[at] << 8 | frame.data[at + 1]);
}

/// A number in [min, max] as 0..2^bits - 1, and back; values outside are pulled in, NaN becomes the middle.
inline std::uint32_t to_steps(double value, double min, double max, int bits) {
  const double top = static_cast<double>((1u << bits) - 1);
  const double steps = (value - min) / (max - min) * top;
  if (!(steps == steps)) return (1u << bits) / 2;
  return steps <= 0 ? 0u : steps >= top ? static_cast<std::uint32_t>(top) : static_cast<std::uint32_t>(steps + 0.5);
}
inline double from_steps(std::uint32_t steps, double min, double max, int bits) {
  return min + static_cast<double>(steps) * (max - min) / static_cast<double>((1u << bits) - 1);
}

}  // namespace sinew::wire
