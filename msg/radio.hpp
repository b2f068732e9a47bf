#pragma once
#include "msg/describe.hpp"

namespace sinew::msg {

/// Most bytes of a datagram: fits one Ethernet frame behind the headers of IPv6, UDP and RTPS, so that a lost frame
/// loses one datagram and none is put together from parts.
inline constexpr std::size_t kMaxDatagramBytes = 1200;

/// One datagram that a radio received: the bytes as they came, and who sent them by the transport's own knowledge.
struct Datagram {
  Time stamp;                // when it arrived; of the kernel where it says so
  std::uint32_t sender = 0;  // UDP: the IPv4 address, 192.168.1.2 is 0xC0A80102; a simulated air: the robot's number
  std::uint32_t port = 0;    // UDP: the sender's port; else 0
  std::uint32_t size = 0;    // bytes of `data` in use; the others are 0
  std::uint32_t lost = 0;    // datagrams that arrived before this one since the last, and found no room
  std::array<std::uint8_t, kMaxDatagramBytes> data{};

  std::span<const std::uint8_t> bytes() const {
    return {data.data(), size < kMaxDatagramBytes ? size : kMaxDatagramBytes};
  }
};

template <>
struct Description<Datagram> {
  static constexpr std::string_view name = "Datagram", doc = "One datagram that a radio received.";
  static constexpr auto fields = describe(
      field<&Datagram::stamp>("ns", "when it arrived"), field<&Datagram::sender>("1", "UDP: IPv4 address, as a number"),
      field<&Datagram::port>("1", "UDP: the sender's; else 0"), field<&Datagram::size>("B", "of data"),
      field<&Datagram::lost>("1", "since the one before, for lack of room"),
      field<&Datagram::data>("1", "0 beyond size"));
};

}  // namespace sinew::msg
