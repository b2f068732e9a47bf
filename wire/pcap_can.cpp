#include "wire/pcap_can.hpp"

#include <algorithm>

namespace sinew::wire {
namespace {

constexpr std::uint32_t kPcapExtendedBit = 0x80000000, kPcapRemoteBit = 0x40000000,
                        kPcapErrorBit = 0x20000000;       // linux/can.h
constexpr std::uint8_t kBitRateSwitch = 1, kFdFrame = 4;  // CANFD_BRS, CANFD_FDF

void put_pcap32(std::uint8_t* at, std::uint32_t value) {
  for (int i = 0; i < 4; ++i) at[i] = static_cast<std::uint8_t>(value >> (8 * i));
}

}  // namespace

std::array<std::uint8_t, kPcapHead> pcap_can_head() noexcept {
  std::array<std::uint8_t, kPcapHead> head{};
  put_pcap32(&head[0], 0xA1B23C4D);  // little endian, nanoseconds
  head[4] = 2, head[6] = 4;          // version 2.4
  put_pcap32(&head[16], 65535);      // longest record
  put_pcap32(&head[20], 227);        // LINKTYPE_CAN_SOCKETCAN
  return head;
}

std::size_t pcap_can_record(const msg::CanFrame& frame, std::span<std::uint8_t> out) noexcept {
  if (frame.size > msg::kMaxCanBytes || frame.stamp.ns < 0 || frame.stamp.ns / 1'000'000'000 > 0xFFFFFFFFll) return 0;
  const std::uint32_t size = 8 + (frame.remote() ? 0 : frame.size);
  if (out.size() < 16 + size) return 0;
  put_pcap32(&out[0], static_cast<std::uint32_t>(frame.stamp.ns / 1'000'000'000));
  put_pcap32(&out[4], static_cast<std::uint32_t>(frame.stamp.ns % 1'000'000'000));
  put_pcap32(&out[8], size), put_pcap32(&out[12], size);
  const std::uint32_t id = frame.id | (frame.extended() ? kPcapExtendedBit : 0) |
                           (frame.remote() ? kPcapRemoteBit : 0) | (frame.error() ? kPcapErrorBit : 0);
  for (std::size_t i = 0; i < 4; ++i) out[16 + i] = static_cast<std::uint8_t>(id >> (24 - 8 * i));
  out[20] = static_cast<std::uint8_t>(frame.size);
  out[21] = static_cast<std::uint8_t>((frame.fd() ? kFdFrame : 0) |
                                      ((frame.flags & msg::kCanBitRateSwitch) != 0 ? kBitRateSwitch : 0));
  out[22] = out[23] = 0;
  std::copy_n(frame.data.begin(), size - 8, out.begin() + 24);
  return 16 + size;
}

}  // namespace sinew::wire
