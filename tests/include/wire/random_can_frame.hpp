#pragma once
// Frames for round trips: every kind, every size.
#include <random>

#include "msg/can.hpp"

namespace sinew::wire {

inline msg::CanFrame random_can_frame(std::mt19937& random, bool with_remote, bool with_fd) {
  static constexpr std::uint32_t kFdSizes[] = {0, 1, 7, 8, 12, 16, 20, 24, 32, 48, 64};
  msg::CanFrame frame;
  if (random() % 2 == 0) frame.flags |= msg::kCanExtended;
  frame.id = static_cast<std::uint32_t>(random()) & (frame.extended() ? 0x1FFFFFFFu : 0x7FFu);
  const auto kind = random() % 3;
  if (kind == 0 && with_fd) {
    frame.flags |= msg::kCanFd;
    frame.size = kFdSizes[random() % 11];
  } else {
    frame.size = static_cast<std::uint32_t>(random() % 9);
    if (kind == 1 && with_remote) frame.flags |= msg::kCanRemote;
  }
  if (!frame.remote())
    for (std::uint32_t i = 0; i < frame.size; ++i) frame.data[i] = static_cast<std::uint8_t>(random());
  return frame;
}

inline bool same_frame(const msg::CanFrame& a, const msg::CanFrame& b) {
  return a.id == b.id && a.flags == b.flags && a.size == b.size && a.data == b.data;
}

inline msg::CanFrame frame_of(std::uint32_t id, std::initializer_list<std::uint8_t> data, std::uint32_t flags = 0) {
  msg::CanFrame frame;
  frame.id = id, frame.flags = flags, frame.size = static_cast<std::uint32_t>(data.size());
  std::uint32_t i = 0;
  for (const std::uint8_t byte : data) frame.data[i++] = byte;
  return frame;
}

}  // namespace sinew::wire
