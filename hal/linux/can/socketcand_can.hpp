#pragma once
#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "hal/linux/can/can_port.hpp"
#include "hal/self_report.hpp"
#include "wire/socketcand.hpp"

namespace sinew::hal {

/// A CAN bus of another machine, behind a socketcand server: address "HOST:PORT/BUS" ("[::1]:29536/can0"). When the
/// connection is lost, a thread of this object connects again, first after 100 ms and later every second; until then
/// read() and send() say closed.
///
/// Stamps are times of reading here: the server's clock is another one. Bytes in TCP's buffer cannot be taken back; the
/// buffer is kept small, and when it is full send() says timeout. A frame that a loss cuts is lost. For an error frame
/// the protocol gives only its class. Own frames never come back: receive_own is refused.
class SocketcandCan final : public CanPort, public SelfReport {
 public:
  /// Connects once, for at most about two seconds.
  /// Errors:  bad_argument: the address; not_supported: receive_own; not_found, closed, timeout: no socketcand server
  ///          there; denied: the server refuses the bus; io.
  static Result<std::unique_ptr<CanBus>> open(const CanSpec& spec, Os& os, std::shared_ptr<FdWatch> watch,
                                              std::string& why);
  ~SocketcandCan() override;

  Result<bool> read(msg::CanFrame& out) noexcept override;
  Status send(const msg::CanFrame& frame, Time deadline) noexcept override;
  /// Filters here: the protocol's raw mode has none.
  Status set_filters(std::span<const CanFilter> filters) override;
  /// The error of the last attempt to connect; empty: connected. Thread: any. RT: no.
  std::string trouble() const override;

 private:
  SocketcandCan(const CanSpec& spec, Os& os, std::shared_ptr<FdWatch> watch) : CanPort(spec, os, std::move(watch)) {}
  Result<int> connect_once(std::string& why);
  Status shake_hands(int fd, std::string& why);
  Status expect_ok(int fd, std::string_view what, std::string& why);
  Status adopt(int fd);
  void lose() noexcept;
  void keep();
  bool take(msg::CanFrame& out) noexcept;
  Status flush() noexcept;

  std::string host_, port_, bus_;
  int fd_ = -1;  // the keeper's, while connected_ is false; else the reader's and sender's
  // read() and send() say that they are inside before they look at connected_; the keeper clears connected_ before it
  // looks whether they are inside. Sequential consistency: one of the two sees the other.
  std::atomic<bool> connected_{false}, reading_{false}, sending_{false}, stop_{false};
  std::atomic<std::uint32_t> connection_{0};  // counts connections: a half sent or read element belongs to one
  WakeWord keeper_word_{0};
  // The reader's:
  wire::SocketcandSplitter splitter_;
  std::array<char, 4096> received_{};
  std::size_t next_ = 0, end_ = 0;
  std::uint32_t read_connection_ = 0;
  std::uint64_t dropped_ = 0;
  std::vector<CanFilter> filters_;
  // The sender's:
  std::array<char, wire::kSocketcandMax> pending_{};  // rest of an element that TCP took in part
  std::size_t pending_next_ = 0, pending_end_ = 0;
  std::uint32_t send_connection_ = 0;

  mutable std::mutex mutex_;  // keeper and trouble(); read() and send() never take it
  std::string trouble_;
  std::unique_ptr<Thread> keeper_;  // last: ends before what it uses
};

}  // namespace sinew::hal
