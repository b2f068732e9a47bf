// Connecting to a socketcand server, also again after a loss.
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "hal/linux/can/socketcand_can.hpp"

namespace sinew::hal {
namespace {

using namespace std::chrono_literals;

constexpr Duration kFirstConnectPause = 100ms, kLongConnectPause = 1s;
constexpr int kConnectMs = 2000, kSocketcandSendBytes = 8 << 10;  // the kernel doubles it

bool wait_for(int fd, short what, int milliseconds) {
  pollfd item{fd, what, 0};
  return poll(&item, 1, milliseconds) == 1;
}

bool send_text(int fd, std::string_view text) {
  return ::send(fd, text.data(), text.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(text.size());
}

}  // namespace

Result<int> SocketcandCan::connect_once(std::string& why) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int code = getaddrinfo(host_.c_str(), port_.c_str(), &hints, &found); code != 0) {
    why = spec_.address + ": " + gai_strerror(code);
    return Error{Errc::not_found, "host", code};
  }
  int fd = -1, error = 0;
  for (const addrinfo* a = found; a != nullptr && fd < 0; a = a->ai_next) {
    fd = socket(a->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (fd < 0) continue;
    socklen_t size = sizeof error;
    error = connect(fd, a->ai_addr, a->ai_addrlen) == 0 ? 0 : errno;
    if (error == EINPROGRESS)
      error = !wait_for(fd, POLLOUT, kConnectMs)                         ? ETIMEDOUT
              : getsockopt(fd, SOL_SOCKET, SO_ERROR, &error, &size) != 0 ? errno
                                                                         : error;
    if (error != 0) close(fd), fd = -1;
  }
  freeaddrinfo(found);
  if (fd < 0) {
    why = spec_.address + ": " + std::strerror(error) + " (does a socketcand run there?)";
    return Error{error == ETIMEDOUT      ? Errc::timeout
                 : error == ECONNREFUSED ? Errc::closed
                                         : Errc::io,
                 "connect", error};
  }
  const int on = 1, bytes = kSocketcandSendBytes, idle_s = 2, interval_s = 1, count = 3, patience_ms = 5000;
  setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  setsockopt(fd, SOL_SOCKET, SO_SNDBUF, &bytes, sizeof bytes);
  // A peer that vanishes without a word is detected within some five seconds.
  setsockopt(fd, SOL_SOCKET, SO_KEEPALIVE, &on, sizeof on);
  setsockopt(fd, IPPROTO_TCP, TCP_KEEPIDLE, &idle_s, sizeof idle_s);
  setsockopt(fd, IPPROTO_TCP, TCP_KEEPINTVL, &interval_s, sizeof interval_s);
  setsockopt(fd, IPPROTO_TCP, TCP_KEEPCNT, &count, sizeof count);
  setsockopt(fd, IPPROTO_TCP, TCP_USER_TIMEOUT, &patience_ms, sizeof patience_ms);
  if (const Status greeted = shake_hands(fd, why); !greeted) {
    close(fd);
    return greeted.error();
  }
  return fd;
}

Status SocketcandCan::shake_hands(int fd, std::string& why) {
  std::array<char, wire::kSocketcandMax> open{};
  const std::size_t open_size = wire::socketcand_open(bus_, open);
  if (const Status hi = expect_ok(fd, "hi", why); !hi) return hi;
  if (!send_text(fd, {open.data(), open_size})) return Error{Errc::closed, "open", errno};
  if (const Status ok = expect_ok(fd, "ok", why); !ok) return ok;
  if (!send_text(fd, "< rawmode >")) return Error{Errc::closed, "rawmode", errno};
  return expect_ok(fd, "ok", why);
}

/// Reads byte by byte: bytes after the answer belong to read().
Status SocketcandCan::expect_ok(int fd, std::string_view what, std::string& why) {
  wire::SocketcandSplitter splitter;
  const Time deadline = os_.now() + Duration(std::chrono::milliseconds(kConnectMs));
  const wire::SocketcandKind wanted = what == "hi" ? wire::SocketcandKind::hi : wire::SocketcandKind::ok;
  for (int characters = 0; characters < 4096;) {
    const auto left_ms = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - os_.now()).count();
    if (left_ms <= 0 || stop_.load(std::memory_order_acquire)) break;
    if (!wait_for(fd, POLLIN, static_cast<int>(std::min<std::int64_t>(left_ms, 100)))) continue;
    char c = 0;
    const ssize_t n = recv(fd, &c, 1, MSG_DONTWAIT);
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) continue;
    if (n <= 0) {
      why = spec_.address + ": the server hung up before '< " + std::string(what) + " >'";
      return Error{Errc::closed, "handshake", n < 0 ? errno : 0};
    }
    ++characters;
    wire::SocketcandMessage message;
    if (!splitter.push(c) || !wire::socketcand_parse(splitter.element(), message)) continue;
    if (message.kind == wanted) return {};
    if (message.kind == wire::SocketcandKind::refused) {
      why = spec_.address + ": the server says: " + std::string(message.text);
      return Error{Errc::denied, "handshake"};
    }
  }
  why = spec_.address + ": the server there does not say '< " + std::string(what) + " >'";
  return Error{Errc::timeout, "handshake"};
}

/// The new connection becomes fd_ while no caller is inside.
Status SocketcandCan::adopt(int fd) {
  connected_.store(false, std::memory_order_seq_cst);
  while (reading_.load(std::memory_order_seq_cst) || sending_.load(std::memory_order_seq_cst))
    os_.sleep_until(os_.now() + 100us);  // as long as one call takes
  if (fd_ >= 0) watch_->remove(fd_), close(fd_);
  fd_ = fd;
  connection_.fetch_add(1, std::memory_order_relaxed);  // connected_ publishes it
  if (const Status watched = watch_->add(fd_, line_); !watched) return watched;
  counters_.set_state(CanState::active);
  connected_.store(true, std::memory_order_seq_cst);
  line_.ring();
  return {};
}

void SocketcandCan::lose() noexcept {
  counters_.set_state(CanState::stopped);
  if (!connected_.exchange(false, std::memory_order_seq_cst)) return;
  keeper_word_.fetch_add(1, std::memory_order_release);
  os_.wake(keeper_word_);
}

void SocketcandCan::keep() {
  Duration pause = kFirstConnectPause;
  while (!stop_.load(std::memory_order_acquire)) {
    const std::uint32_t seen = keeper_word_.load(std::memory_order_acquire);
    if (connected_.load(std::memory_order_seq_cst)) {
      pause = kFirstConnectPause;
      os_.wait(keeper_word_, seen, kNever);
      continue;
    }
    std::string why;
    const auto fd = connect_once(why);
    if (fd && !adopt(*fd)) why = spec_.address + ": cannot be watched";
    {
      const std::lock_guard lock(mutex_);
      trouble_ = why;
    }
    if (fd) continue;
    os_.wait(keeper_word_, seen, os_.now() + pause);
    pause = std::min<Duration>(2 * pause, kLongConnectPause);
  }
}

std::string SocketcandCan::trouble() const {
  const std::lock_guard lock(mutex_);
  return trouble_;
}

}  // namespace sinew::hal
