#pragma once
#include <netinet/in.h>

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "hal/connectors.hpp"
#include "hal/linux/udp_batch.hpp"
#include "hal/sample_ring.hpp"
#include "hal/self_report.hpp"
#include "hal/sensor_queue.hpp"
#include "hal/wide.hpp"

namespace sinew::hal {

/// A radio made of UDP: RadioSpec.
///
/// A thread of ordinary priority receives, so that a flood takes no time from the loops: it moves at most as many
/// datagrams as the reader has room for, and leaves the rest to the kernel, which drops it. The same thread follows the
/// network: when the interface appears, goes, comes back or gets another address, it joins the group again. Neither
/// read() nor send() waits for any of that.
///
/// Robots of one machine share the group's port, and each sends from a port of its own; by that, and by the addresses
/// of this machine, own datagrams are known and dropped. Anybody on the network can send anything here.
///
/// Stamps: the kernel's, as the datagram came in, on the clock of `os`.
/// Datagram::lost, rx_lost: what the kernel dropped; both are known when the next datagram comes.
class UdpRadio final : public Radio, public SelfReport {
 public:
  /// Opens without a network, too.
  /// Errors:  bad_argument: the spec; busy: another program has the port (peers); denied, io. `why` has it in words.
  static Result<std::unique_ptr<Radio>> open(const RadioSpec& spec, Os& os, std::string& why);
  ~UdpRadio() override;
  UdpRadio(const UdpRadio&) = delete;
  UdpRadio& operator=(const UdpRadio&) = delete;

  Result<bool> read(msg::Datagram& out) noexcept override;
  Time ready_at() const noexcept override { return ring_.size() > 0 ? Time{} : kNever; }
  void set_wake(Wake* wake) noexcept override { wake_.change(wake); }
  Status send(std::span<const std::uint8_t> bytes) noexcept override;
  Status send_to(const UdpAddress& to, std::span<const std::uint8_t> bytes) noexcept override;
  RadioStats stats() const noexcept override;

  std::string trouble() const override;
  std::string shortfall() const override { return thread_ ? thread_->shortfall() : std::string(); }

  /// Datagrams that wait for a reader, at most; what the socket holds besides, in bytes.
  static constexpr std::size_t kWaiting = 64;
  static constexpr int kSocketBytes = 256 << 10;

 private:
  /// An interface of this machine.
  struct Link {
    std::string name;
    int index = 0;
    unsigned flags = 0;                // IFF_UP, ...
    std::vector<std::uint32_t> ipv4s;  // its addresses
  };

  /// An address of this machine. What was sent from it may be in the socket when it is no longer.
  struct OwnAddress {
    std::uint32_t ipv4 = 0;
    Time last_seen;
  };

  UdpRadio(const RadioSpec& spec, Os& os);
  Status open_group();
  Status open_port();
  void run() noexcept;
  void receive() noexcept;
  void look_at_network() noexcept;
  void note_own(const std::vector<Link>& links);
  void look_at_losses() noexcept;
  const Link* choose(const std::vector<Link>& links, std::string& why) const;
  std::uint32_t source_by_route() const noexcept;
  bool join(int index, std::uint32_t source) noexcept;
  void leave() noexcept;
  bool is_own(const UdpPacket& packet) const noexcept;
  bool has_group() const { return spec_.peers.empty() && !spec_.listens; }
  Status send_to(std::span<const sockaddr_in> all, std::span<const std::uint8_t> bytes) noexcept;
  Status not_sent(Errc code, const char* where, int error) noexcept;
  std::string titled(const std::string& what) const;
  static std::vector<Link> links();

  const RadioSpec spec_;
  Os& os_;
  int in_ = -1, out_ = -1;  // with peers one socket
  int network_ = -1;        // tells of changes of interfaces and addresses; -1: looked at each second only
  int stop_ = -1;
  std::vector<sockaddr_in> to_;

  // The thread's own, and open()'s before it.
  UdpBatch batch_;
  msg::Datagram incoming_;
  std::uint16_t own_port_ = 0;
  std::vector<OwnAddress> own_;
  int joined_ = 0;            // index of the interface; 0: none
  std::uint32_t source_ = 0;  // what is sent comes from this address of it
  std::uint32_t lost_ = 0;
  std::uint64_t lost_before_ = 0;

  SampleRing<msg::Datagram> ring_{kWaiting};
  WakeSlot wake_;
  Tally received_, received_bytes_, sent_, sent_bytes_, rx_lost_, rx_other_, tx_lost_;
  // Relaxed: each says only what it says.
  std::atomic<bool> online_{false}, crowded_{false};
  std::atomic<int> send_error_{0};  // errno of the last send(); 0: it went out
  TroubleText network_trouble_;
  std::unique_ptr<Thread> thread_;
};

}  // namespace sinew::hal
