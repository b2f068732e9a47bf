#include "hal/linux/can/socketcand_can.hpp"

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "hal/linux/can/can_error.hpp"

namespace sinew::hal {
namespace {

/// Marks a caller as inside during its lifetime.
class In {
 public:
  explicit In(std::atomic<bool>& in) : in_(in) { in_.store(true, std::memory_order_seq_cst); }
  ~In() { in_.store(false, std::memory_order_release); }
  In(const In&) = delete;
  In& operator=(const In&) = delete;

 private:
  std::atomic<bool>& in_;
};

/// "HOST:PORT/BUS", "[HOST]:PORT/BUS"
bool split_address(const std::string& text, std::string& host, std::string& port, std::string& bus) {
  const std::size_t slash = text.rfind('/');
  if (slash == std::string::npos) return false;
  bus = text.substr(slash + 1);
  const std::string peer = text.substr(0, slash);
  const std::size_t colon = peer.rfind(':');
  if (colon == std::string::npos) return false;
  host = peer.substr(0, colon), port = peer.substr(colon + 1);
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
  std::array<char, wire::kSocketcandMax> text_of_bus{};
  return !host.empty() && !port.empty() && wire::socketcand_open(bus, text_of_bus) != 0 &&
         std::all_of(port.begin(), port.end(), [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

Result<std::unique_ptr<CanBus>> SocketcandCan::open(const CanSpec& spec, Os& os, std::shared_ptr<FdWatch> watch,
                                                    std::string& why) {
  why.clear();
  std::unique_ptr<SocketcandCan> bus(new SocketcandCan(spec, os, std::move(watch)));
  if (!split_address(spec.address, bus->host_, bus->port_, bus->bus_)) {
    why = "'" + spec.address + "' is no bus of a socketcand server: HOST:PORT/BUS, as in localhost:29536/can0";
    return Error{Errc::bad_argument, "address"};
  }
  if (spec.receive_own) {
    why = spec.address + ": a socketcand server does not send back what came from here (receive_own)";
    return Error{Errc::not_supported, "receive_own"};
  }
  const auto fd = bus->connect_once(why);
  if (!fd) return fd.error();
  if (const Status adopted = bus->adopt(*fd); !adopted) return adopted.error();
  ThreadOptions options;
  options.name = "socketcand";
  auto keeper = os.start_thread(options, [b = bus.get()] { b->keep(); });
  if (!keeper) return keeper.error();
  bus->keeper_ = std::move(*keeper);
  return std::unique_ptr<CanBus>(std::move(bus));
}

SocketcandCan::~SocketcandCan() {
  stop_.store(true, std::memory_order_release);
  keeper_word_.fetch_add(1, std::memory_order_release);
  os_.wake(keeper_word_);
  keeper_.reset();
  if (fd_ < 0) return;
  watch_->remove(fd_);
  close(fd_);
}

Status SocketcandCan::set_filters(std::span<const CanFilter> filters) {
  filters_.assign(filters.begin(), filters.end());
  return {};
}

bool SocketcandCan::take(msg::CanFrame& out) noexcept {
  while (next_ < end_) {
    if (!splitter_.push(received_[next_++])) continue;
    wire::SocketcandMessage message;
    if (!wire::socketcand_parse(splitter_.element(), message)) {
      counters_.malformed();
      continue;
    }
    if (message.kind != wire::SocketcandKind::frame) continue;
    if (message.frame.fd() && spec_.data_bit_rate == 0) {
      counters_.malformed();
      continue;
    }
    if (!passes(filters_, message.frame)) continue;
    out = message.frame;
    out.stamp = os_.now();
    if (out.error())
      count_error_frame(out, counters_);
    else
      counters_.received(out);
    return true;
  }
  counters_.malformed(static_cast<std::uint32_t>(splitter_.dropped() - dropped_));
  dropped_ = splitter_.dropped();
  return false;
}

Result<bool> SocketcandCan::read(msg::CanFrame& out) noexcept {
  const In in(reading_);
  if (!connected_.load(std::memory_order_seq_cst)) return Error{Errc::closed, "server"};
  if (const auto now = connection_.load(std::memory_order_relaxed); now != read_connection_) {
    read_connection_ = now;
    splitter_.reset();
    next_ = end_ = 0;
  }
  for (;;) {
    if (take(out)) return true;
    const ssize_t n = recv(fd_, received_.data(), received_.size(), MSG_DONTWAIT);
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) return false;
    if (n <= 0) {
      lose();
      return Error{Errc::closed, "server", n < 0 ? errno : 0};
    }
    next_ = 0, end_ = static_cast<std::size_t>(n);
  }
}

/// Sends the rest of the last element. Errors: timeout: no room; closed.
Status SocketcandCan::flush() noexcept {
  while (pending_next_ < pending_end_) {
    const ssize_t n = ::send(fd_, &pending_[pending_next_], pending_end_ - pending_next_, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0 && (errno == EAGAIN || errno == ENOBUFS)) return Error{Errc::timeout, "no room", errno};
    if (n < 0) {
      const int error = errno;
      lose();
      return Error{Errc::closed, "server", error};
    }
    pending_next_ += static_cast<std::size_t>(n);
  }
  return {};
}

Status SocketcandCan::send(const msg::CanFrame& frame, Time deadline) noexcept {
  if (const Status may = may_leave(frame, deadline); !may) return may;
  const In in(sending_);
  if (!connected_.load(std::memory_order_seq_cst)) return lost(Errc::closed, "server");
  if (const auto now = connection_.load(std::memory_order_relaxed); now != send_connection_) {
    send_connection_ = now;
    pending_next_ = pending_end_ = 0;
  }
  if (const Status flushed = flush(); !flushed) {
    counters_.tx_lost();
    return flushed;
  }
  pending_next_ = 0;
  pending_end_ = wire::socketcand_send(frame, pending_);
  const Status sent = flush();
  if (!sent && (sent.error().code != Errc::timeout || pending_next_ == 0)) {
    pending_end_ = 0;
    counters_.tx_lost();
    return sent;
  }
  counters_.sent(frame);  // all of it is sent, or its rest goes before the next frame
  return {};
}

}  // namespace sinew::hal
