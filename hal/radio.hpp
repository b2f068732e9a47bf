#pragma once
#include <cstdint>
#include <span>

#include "hal/device.hpp"
#include "hal/udp_address.hpp"
#include "msg/radio.hpp"

namespace sinew::hal {

/// Everything is counted since the radio was opened.
struct RadioStats {
  std::uint64_t received = 0, sent = 0;  // datagrams; where they go to peers one by one, each counts
  std::uint64_t received_bytes = 0, sent_bytes = 0;
  std::uint64_t rx_lost = 0;   // arrived, and found no room
  std::uint64_t rx_other = 0;  // longer than a Datagram holds, or empty: dropped
  std::uint64_t tx_lost = 0;   // the system had no room, or there was no network
};

/// A radio: bounded datagrams to and from whoever listens on the same channel, without any promise. Datagrams may be
/// lost, repeated and reordered, and a peer may send anything. Own datagrams do not come back.
/// A radio opens also where there is no network yet, and goes on when the network comes, goes and changes its address.
/// Thread:  read() on one thread, send() on one thread; they may differ. stats() any.
/// RT:      read() and send() never block.
class Radio : public Sensor<msg::Datagram> {
 public:
  /// Queues one datagram to all; never waits.
  /// Errors:  bad_argument: empty, or longer than msg::kMaxDatagramBytes; busy: the system has no room; closed: no
  ///          network just now. A datagram that was not sent is counted in tx_lost; a later call may succeed.
  virtual Status send(std::span<const std::uint8_t> bytes) noexcept = 0;
  /// The same to one address, for example the sender of a datagram. Errors: also not_supported: this radio has no
  /// addresses.
  virtual Status send_to(const UdpAddress& /*to*/, std::span<const std::uint8_t> /*bytes*/) noexcept {
    return Error{Errc::not_supported, "send to an address"};
  }
  virtual RadioStats stats() const noexcept = 0;
};

}  // namespace sinew::hal
