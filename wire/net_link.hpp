#pragma once
// What a robot and the program beside it that has the network (sinew net) say to each other over a local socket
// (SOCK_SEQPACKET): one packet each time, little-endian. docs/net.md has the bytes.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace sinew::wire {

inline constexpr std::uint8_t kNetLinkVersion = 1;
inline constexpr std::size_t kNetLinkHeadBytes = 20, kNetLinkMostDatagram = 1200;
inline constexpr std::size_t kNetLinkMostText = 60'000;  // of an answer; a state has kNetLinkMostDatagram

enum class NetLinkKind : std::uint8_t {
  hello = 1,   // robot to program, first: wants what is heard
  say = 2,     // robot to program: a datagram for all
  heard = 3,   // program to robot: a datagram
  state = 4,   // program to robot: what is wrong now, in words; empty: nothing
  ask = 5,     // anybody to program: how is it?
  answer = 6,  // program to who asked: JSON
};

struct NetLinkPacket {
  NetLinkKind kind = NetLinkKind::hello;
  std::uint32_t sender = 0;   // heard: from its DDS participant's GUID
  std::uint32_t lost = 0;     // heard: datagrams before this one, since the last, that found no room
  std::int64_t stamp_ns = 0;  // heard: when it arrived, by CLOCK_MONOTONIC of this machine
  std::span<const std::uint8_t> payload{};
};

/// Nothing: it is no packet of this version, its length does not fit its kind, or fields that its kind does not have
/// are not 0. `payload` points into `bytes`. RT: yes.
std::optional<NetLinkPacket> read_net_link(std::span<const std::uint8_t> bytes) noexcept;

/// Writes it to `out`; its size, 0: it does not fit, or its payload is too long for its kind. RT: yes.
std::size_t write_net_link(const NetLinkPacket& packet, std::span<std::uint8_t> out) noexcept;

}  // namespace sinew::wire
