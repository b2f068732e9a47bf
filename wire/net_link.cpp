#include "wire/net_link.hpp"

#include <algorithm>

namespace sinew::wire {
namespace {

bool fits_kind(const NetLinkPacket& p) noexcept {
  const std::size_t size = p.payload.size();
  const bool is_heard = p.kind == NetLinkKind::heard;
  if (!is_heard && (p.sender != 0 || p.lost != 0 || p.stamp_ns != 0)) return false;
  switch (p.kind) {
    case NetLinkKind::hello:
    case NetLinkKind::ask:
      return size == 0;
    case NetLinkKind::say:
    case NetLinkKind::heard:
      return size > 0 && size <= kNetLinkMostDatagram;
    case NetLinkKind::state:
      return size <= kNetLinkMostDatagram;
    case NetLinkKind::answer:
      return size <= kNetLinkMostText;
  }
  return false;
}

template <class T>
void put_net(std::uint8_t* to, T value) noexcept {
  for (std::size_t i = 0; i < sizeof value; ++i)
    to[i] = static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> (8 * i));
}

std::uint64_t get_net(const std::uint8_t* from, std::size_t bytes) noexcept {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < bytes; ++i) value |= std::uint64_t{from[i]} << (8 * i);
  return value;
}

}  // namespace

std::optional<NetLinkPacket> read_net_link(std::span<const std::uint8_t> bytes) noexcept {
  if (bytes.size() < kNetLinkHeadBytes || bytes[0] != kNetLinkVersion || bytes[2] != 0 || bytes[3] != 0)
    return std::nullopt;
  NetLinkPacket p;
  p.kind = static_cast<NetLinkKind>(bytes[1]);
  p.sender = static_cast<std::uint32_t>(get_net(&bytes[4], 4));
  p.lost = static_cast<std::uint32_t>(get_net(&bytes[8], 4));
  p.stamp_ns = static_cast<std::int64_t>(get_net(&bytes[12], 8));
  p.payload = bytes.subspan(kNetLinkHeadBytes);
  if (!fits_kind(p)) return std::nullopt;
  return p;
}

std::size_t write_net_link(const NetLinkPacket& p, std::span<std::uint8_t> out) noexcept {
  const std::size_t size = kNetLinkHeadBytes + p.payload.size();
  if (!fits_kind(p) || out.size() < size) return 0;
  out[0] = kNetLinkVersion;
  out[1] = static_cast<std::uint8_t>(p.kind);
  out[2] = out[3] = 0;
  put_net(&out[4], p.sender);
  put_net(&out[8], p.lost);
  put_net(&out[12], p.stamp_ns);
  std::copy(p.payload.begin(), p.payload.end(), out.begin() + kNetLinkHeadBytes);
  return size;
}

}  // namespace sinew::wire
