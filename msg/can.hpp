#pragma once
#include "msg/describe.hpp"

namespace sinew::msg {

inline constexpr std::size_t kMaxCanBytes = 64;  // of a CAN FD frame; 8 of a classic one

/// Properties of a CAN frame besides its identifier and its data; bits, or-ed.
enum CanFlag : std::uint32_t {
  kCanExtended = 1,       // 29-bit identifier
  kCanRemote = 2,         // asks for data and carries none
  kCanFd = 4,             // CAN FD: up to 64 bytes
  kCanBitRateSwitch = 8,  // CAN FD: data at the faster bit rate
  kCanError = 16,         // no frame of a node: the controller reports a condition of the bus in `id` and `data`
};

inline constexpr ValueName kCanFlagNames[] = {{"extended", kCanExtended},
                                              {"remote", kCanRemote},
                                              {"fd", kCanFd},
                                              {"bit rate switch", kCanBitRateSwitch},
                                              {"error", kCanError}};

/// One CAN frame. As on Linux, the `id` of an error frame has the CAN_ERR_* bits (linux/can/error.h).
struct CanFrame {
  Time stamp;  // end of the frame on the bus, where the hardware says so; else when it was received
  std::uint32_t id = 0;
  std::uint32_t flags = 0;  // CanFlag bits
  std::uint32_t size = 0;   // bytes of `data` in use: 0..8, with CAN FD 0..8, 12, 16, 20, 24, 32, 48, 64
  std::uint32_t bus = 0;    // free for a collector of frames of several buses
  std::array<std::uint8_t, kMaxCanBytes> data{};

  bool extended() const { return (flags & kCanExtended) != 0; }
  bool remote() const { return (flags & kCanRemote) != 0; }
  bool fd() const { return (flags & kCanFd) != 0; }
  bool error() const { return (flags & kCanError) != 0; }
  std::span<const std::uint8_t> bytes() const { return {data.data(), size < kMaxCanBytes ? size : kMaxCanBytes}; }
};

template <>
struct Description<CanFrame> {
  static constexpr std::string_view name = "CanFrame", doc = "One frame of a CAN bus.";
  static constexpr auto fields =
      describe(field<&CanFrame::stamp>("ns", "end of the frame on the bus"), field<&CanFrame::id>("1", "11 or 29 bits"),
               bits_field<&CanFrame::flags>(kCanFlagNames), field<&CanFrame::size>("B", "of data"),
               field<&CanFrame::bus>("1", "which bus"), field<&CanFrame::data>("1"));
};

}  // namespace sinew::msg
