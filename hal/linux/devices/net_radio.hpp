#pragma once
#include <array>
#include <atomic>
#include <memory>
#include <string>

#include "hal/os.hpp"
#include "hal/radio.hpp"
#include "hal/sample_ring.hpp"
#include "hal/self_report.hpp"
#include "hal/sensor_queue.hpp"
#include "hal/wide.hpp"

namespace sinew::hal {

/// Where the program with the network listens for the robot `name`. Errors: those of run_dir().
Result<std::string> net_socket_path(const std::string& name, std::string& why);

/// Asks the program of a robot how it is: JSON. Errors: not_found: it does not run; timeout, io. `why` has it in words.
Result<std::string> ask_net(const std::string& name, Duration patience, std::string& why);

/// A radio that another program is: `sinew net`, which has the network (docs/net.md). Datagrams go to it and come from
/// it over a local socket, bounded on both sides.
///
/// A thread of ordinary priority receives, and looks for the program: it opens without one, and goes on when the
/// program comes, ends and comes again. send() writes to the socket without waiting; a full one loses the datagram.
///
/// Stamps: when the program got it from DDS, on the clock of `os`.
class NetRadio final : public Radio, public SelfReport {
 public:
  /// Opens without the program, too.
  /// Errors:  bad_argument: the name; denied: the folder of sockets; io. `why` has it in words.
  static Result<std::unique_ptr<Radio>> open(const std::string& name, Os& os, std::string& why);
  ~NetRadio() override;
  NetRadio(const NetRadio&) = delete;
  NetRadio& operator=(const NetRadio&) = delete;

  Result<bool> read(msg::Datagram& out) noexcept override;
  Time ready_at() const noexcept override { return ring_.size() > 0 ? Time{} : kNever; }
  void set_wake(Wake* wake) noexcept override { wake_.change(wake); }
  Status send(std::span<const std::uint8_t> bytes) noexcept override;
  RadioStats stats() const noexcept override;

  std::string trouble() const override;
  std::string shortfall() const override { return thread_ ? thread_->shortfall() : std::string(); }

  static constexpr std::size_t kWaiting = 64;  // datagrams that wait for a reader, at most
  /// How long a program that was never there is said to start.
  static constexpr Duration kStarts = std::chrono::seconds(10);

 private:
  NetRadio(std::string name, Os& os) : name_(std::move(name)), os_(os), opened_(os.now()) {}
  void run() noexcept;
  bool connect_now() noexcept;
  void lose() noexcept;
  void receive() noexcept;
  Status not_sent(Errc code, const char* where, int error) noexcept;

  const std::string name_;
  Os& os_;
  const Time opened_;
  std::string path_;
  // One number for ever: the thread puts another socket behind it (dup2) while send() may use it. Without the program
  // it is a socket without a peer.
  int socket_ = -1;
  int stop_ = -1;

  // The thread's own.
  msg::Datagram incoming_;
  std::array<std::uint8_t, 2048> packet_{};

  SampleRing<msg::Datagram> ring_{kWaiting};
  WakeSlot wake_;
  Tally received_, received_bytes_, sent_, sent_bytes_, rx_lost_, rx_other_, tx_lost_;
  std::atomic<bool> connected_{false}, was_connected_{false};  // relaxed: each says only what it says
  TroubleText program_trouble_;
  std::unique_ptr<Thread> thread_;
};

}  // namespace sinew::hal
