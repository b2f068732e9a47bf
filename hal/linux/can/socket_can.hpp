#pragma once
// CAN by the kernel: a raw socket on an interface such as can0 or vcan0.
// Source:  Documentation/networking/can.rst ("RAW protocol sockets"), linux/can/raw.h.
#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "hal/linux/can/can_link.hpp"
#include "hal/linux/can/can_port.hpp"
#include "hal/self_report.hpp"

namespace sinew::hal {

/// Receives in batches of up to 16 frames. Other programs on this machine see the frames that it sends, and it sees
/// theirs; its own frames come back only with CanSpec::receive_own.
///
/// Its own thread looks for a lost interface (down, unplugged), first every 100 ms and later each second; then the same
/// socket goes on. A controller that is bus-off comes back by the interface's restart-ms. If restart-ms is 0, this
/// object restarts the controller by netlink, which needs CAP_NET_ADMIN; trouble() says when it may not.
///
/// Deadlines: a frame whose deadline is over is not handed to the kernel. A frame in the kernel cannot be taken back,
/// so the socket's buffer is small (about 32 frames, or 10 by the queue of the interface unless its txqueuelen is
/// raised): when it is full, send() says timeout at once. A bus that is off drops the waiting frames.
///
/// Stamps: the controller's where its driver gives them, else the kernel's; both on CLOCK_MONOTONIC (can_stamp.hpp,
/// hal/linux/realtime_stamps.hpp). Filters are the kernel's; error frames always come.
class SocketCanBus final : public CanPort, public SelfReport {
 public:
  /// `why`: on an error what is missing and what to do; on success empty, or what will be missing later.
  /// Errors:  not_supported: the kernel has no CAN, or CAN FD is asked for and not there; not_found: no such interface;
  ///          bad_argument: it is no CAN interface; denied; io.
  static Result<std::unique_ptr<CanBus>> open(const CanSpec& spec, Os& os, std::shared_ptr<FdWatch> watch,
                                              std::string& why);
  ~SocketCanBus() override;

  Result<bool> read(msg::CanFrame& out) noexcept override;
  Status send(const msg::CanFrame& frame, Time deadline) noexcept override;
  Status set_filters(std::span<const CanFilter> filters) override;
  /// The reasons why the bus does not work, in words; empty: none. Thread: any. RT: no.
  std::string trouble() const override;

 private:
  struct Batch;

  SocketCanBus(const CanSpec& spec, Os& os, std::shared_ptr<FdWatch> watch);
  Status open_socket(std::string& why);
  Status set_options(const CanLink& link, std::string& why);
  Status bind_to(int index);
  Status apply_filters();
  Result<bool> fill() noexcept;
  bool take(std::size_t i, msg::CanFrame& out) noexcept;
  Time stamp_of(std::size_t i) noexcept;
  void lose() noexcept;
  void keep();
  bool look();  // true: there is something to wait for
  void follow_controller(const CanLink& link, std::uint64_t error_frames_before, std::string& trouble);

  int fd_ = -1;
  std::unique_ptr<Batch> batch_;
  std::uint32_t overflow_ = 0;  // the socket's own count when last seen; wraps
  std::atomic<int> bound_{0};   // index of the interface
  std::atomic<bool> lost_{false}, stop_{false};
  WakeWord keeper_word_{0};
  mutable std::mutex mutex_;  // the keeper and configuration; read() and send() never take it
  std::string trouble_;
  std::vector<CanFilter> filters_;
  std::unique_ptr<Thread> keeper_;  // last: ends before what it uses
};

}  // namespace sinew::hal
