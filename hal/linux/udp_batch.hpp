#pragma once
// UDP as the hal's sockets receive it: many datagrams a system call, each with the kernel's stamp and count of losses.
#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "hal/linux/realtime_stamps.hpp"

namespace sinew::hal {

/// One received datagram.
struct UdpPacket {
  std::span<const std::uint8_t> bytes{};  // in the batch, until its next fill()
  std::uint32_t ipv4 = 0;                 // of the sender, as a number: 127.0.0.1 is 0x7F000001
  std::uint16_t port = 0;                 // of the sender
  bool cut = false;                       // it was longer than the batch has room for
  std::uint32_t lost = 0;                 // datagrams since the one before that found no room in the socket
  Time stamp;
};

/// Reads datagrams of one socket, which UdpBatch::prepare() was called for.
/// Thread:  owner.   RT: yes after construction; fill() does not block.
class UdpBatch {
 public:
  /// Room for `packets` datagrams of at most `bytes` each.
  UdpBatch(Os& os, std::size_t packets, std::size_t bytes);

  /// Makes the kernel stamp datagrams and count lost ones; its buffer has `receive_bytes` (which the kernel doubles).
  /// Before bind(). Errors: io.
  static Status prepare(int socket, int receive_bytes) noexcept;

  /// Reads what is there, `most` datagrams at most; says how many. Errors: closed: the interface is down; io.
  Result<std::size_t> fill(int socket, std::size_t most) noexcept;
  /// i < what fill() said.
  const UdpPacket& operator[](std::size_t i) const noexcept { return packets_[i]; }
  std::size_t capacity() const noexcept { return packets_.size(); }

 private:
  using Control = std::array<std::byte, 128>;
  UdpPacket packet(std::size_t i, Time read_at) noexcept;

  Os& os_;
  RealtimeStamps realtime_;
  std::size_t bytes_;
  std::vector<std::uint8_t> memory_;
  std::vector<UdpPacket> packets_;
  std::unique_ptr<Control[]> control_;
  std::vector<sockaddr_in> from_;
  std::vector<iovec> parts_;
  std::vector<mmsghdr> heads_;
  std::uint32_t overflow_ = 0;  // the kernel's count of lost datagrams, as of the last one read
};

}  // namespace sinew::hal
