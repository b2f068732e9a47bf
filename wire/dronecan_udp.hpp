#pragma once
// CAN frames in UDP datagrams, as DroneCAN's "mcast" driver and ArduPilot send them: a CAN bus is a multicast group.
// Source:  dronecan/pydronecan, dronecan/driver/mcast.py (its header comment). Little endian: u16 magic 0x2934, u16
//          CRC-16/CCITT-FALSE of all that follows it, u16 flags (bit 0: CAN FD), u32 identifier (bit 31: 29 bits),
//          data.
#include <cstddef>
#include <cstdint>
#include <span>

#include "msg/can.hpp"

namespace sinew::wire {

inline constexpr std::uint16_t kDronecanUdpPort = 57732;
inline constexpr std::size_t kDronecanUdpHead = 10, kDronecanUdpMax = kDronecanUdpHead + msg::kMaxCanBytes;
/// Bus B is the group 239.65.82.B.
inline constexpr std::uint32_t kDronecanUdpGroup = (239u << 24) | (65u << 16) | (82u << 8);

/// Bytes written to `out` (room for kDronecanUdpMax). 0: a frame that this framing cannot carry: error frames, remote
/// frames (it has no place for their length), and what is_can_frame() refuses. The bit rate switch is not carried.
/// RT:      yes.
std::size_t dronecan_udp_encode(const msg::CanFrame& frame, std::span<std::uint8_t> out) noexcept;

/// False: no such datagram (length, magic, CRC, or no frame that is_can_frame() accepts). Leaves stamp and bus alone.
/// RT:      yes.
bool dronecan_udp_decode(std::span<const std::uint8_t> datagram, msg::CanFrame& out) noexcept;

}  // namespace sinew::wire
