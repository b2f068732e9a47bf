#pragma once
// Trace files of CAN frames that tshark and Wireshark read: pcap with nanoseconds, link type 227. The heads of file
// and records are little endian, which the file's first number tells.
// Source:  draft-ietf-opsawg-pcap (file and record header), tcpdump.org "LINKTYPE_CAN_SOCKETCAN" (identifier big
//          endian with the bits of linux/can.h, length, FD flags, two reserved bytes, data).
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "msg/can.hpp"

namespace sinew::wire {

inline constexpr std::size_t kPcapHead = 24, kPcapCanMax = 16 + 8 + msg::kMaxCanBytes;

/// What the file begins with.
std::array<std::uint8_t, kPcapHead> pcap_can_head() noexcept;

/// One record: bytes written to `out`; 0: no room (kPcapCanMax is always enough), a size above 64, or a stamp that the
/// file's 32 bits of seconds cannot hold.   RT: yes.
std::size_t pcap_can_record(const msg::CanFrame& frame, std::span<std::uint8_t> out) noexcept;

}  // namespace sinew::wire
