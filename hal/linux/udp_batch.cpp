#include "hal/linux/udp_batch.hpp"

#include <time.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace sinew::hal {

UdpBatch::UdpBatch(Os& os, std::size_t packets, std::size_t bytes)
    : os_(os),
      realtime_(os.now()),
      bytes_(bytes),
      memory_(packets * bytes),
      packets_(packets),
      control_(std::make_unique<Control[]>(packets)),
      from_(packets),
      parts_(packets),
      heads_(packets) {
  for (std::size_t i = 0; i < packets; ++i) {
    parts_[i] = {memory_.data() + i * bytes, bytes};
    heads_[i].msg_hdr.msg_iov = &parts_[i];
    heads_[i].msg_hdr.msg_iovlen = 1;
    heads_[i].msg_hdr.msg_name = &from_[i];
  }
}

Status UdpBatch::prepare(int socket, int receive_bytes) noexcept {
  const int on = 1;
  const auto failed = [](const char* where) -> Status { return Error{Errc::io, where, errno}; };
  if (setsockopt(socket, SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on) != 0) return failed("SO_RXQ_OVFL");
  if (setsockopt(socket, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on) != 0) return failed("SO_TIMESTAMPNS");
  if (setsockopt(socket, SOL_SOCKET, SO_RCVBUF, &receive_bytes, sizeof receive_bytes) != 0) return failed("SO_RCVBUF");
  return {};
}

Result<std::size_t> UdpBatch::fill(int socket, std::size_t most) noexcept {
  most = std::min(most, packets_.size());
  for (std::size_t i = 0; i < most; ++i) {
    heads_[i].msg_hdr.msg_control = &control_[i];
    heads_[i].msg_hdr.msg_controllen = sizeof control_[i];
    heads_[i].msg_hdr.msg_namelen = sizeof from_[i];
  }
  const Time asked = os_.now();
  const int n = recvmmsg(socket, heads_.data(), static_cast<unsigned>(most), MSG_DONTWAIT, nullptr);
  const int error = n < 0 ? errno : 0;
  const ClockReading clocks = read_clocks(os_);
  realtime_.begin(clocks);
  const std::size_t count = n > 0 ? static_cast<std::size_t>(n) : 0;
  for (std::size_t i = 0; i < count; ++i) packets_[i] = packet(i, clocks.before);
  if (error == EAGAIN || (count > 0 && count < most)) realtime_.drained(asked);
  if (error == 0 || error == EAGAIN || error == EINTR) return count;
  return Error{error == ENETDOWN ? Errc::closed : Errc::io, "recvmmsg", error};
}

UdpPacket UdpBatch::packet(std::size_t i, Time read_at) noexcept {
  msghdr& head = heads_[i].msg_hdr;
  UdpPacket out;
  out.bytes = std::span(memory_).subspan(i * bytes_, std::min<std::size_t>(heads_[i].msg_len, bytes_));
  out.ipv4 = ntohl(from_[i].sin_addr.s_addr);
  out.port = ntohs(from_[i].sin_port);
  out.cut = (head.msg_flags & MSG_TRUNC) != 0;
  out.stamp = read_at;
  for (cmsghdr* c = CMSG_FIRSTHDR(&head); c != nullptr; c = CMSG_NXTHDR(&head, c)) {
    if (c->cmsg_level != SOL_SOCKET) continue;
    if (c->cmsg_type == SO_RXQ_OVFL) {
      std::uint32_t seen = 0;
      std::memcpy(&seen, CMSG_DATA(c), sizeof seen);
      out.lost = seen - overflow_;
      overflow_ = seen;
    } else if (c->cmsg_type == SO_TIMESTAMPNS) {
      timespec wall{};
      std::memcpy(&wall, CMSG_DATA(c), sizeof wall);
      out.stamp = realtime_.convert(ns_of(wall));
    }
  }
  return out;
}

}  // namespace sinew::hal
