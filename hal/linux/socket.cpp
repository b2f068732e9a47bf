#include "hal/linux/socket.hpp"

#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "hal/linux/beyond_posix.hpp"
#include "hal/linux/shared_memory.hpp"

namespace sinew::hal {
namespace {

Error system_error(const char* where, int why) {
  switch (why) {
    case EPIPE:
    case ECONNRESET:
    case ECONNREFUSED:
      return {Errc::closed, where, why};
    case EAGAIN:
    case ETIMEDOUT:
      return {Errc::timeout, where, why};
    case ENOENT:
      return {Errc::not_found, where, why};
    case EADDRINUSE:
      return {Errc::busy, where, why};
    case EACCES:
    case EPERM:
      return {Errc::denied, where, why};
    case ENOMEM:
      return {Errc::out_of_memory, where, why};
    default:
      return {Errc::io, where, why};
  }
}

timeval to_timeval(Duration d) {
  timeval tv{};
  tv.tv_sec = static_cast<time_t>(d.count() / 1'000'000'000);
  tv.tv_usec = static_cast<suseconds_t>(d.count() % 1'000'000'000 / 1000);
  if (d.count() > 0 && tv.tv_sec == 0 && tv.tv_usec == 0) tv.tv_usec = 1;  // 0 would mean for ever
  return tv;
}

constexpr Duration kSilence = std::chrono::seconds(5);  // of a TCP peer that does not even acknowledge

constexpr std::size_t kMaxHandles = 4;  // more in one message is not our protocol; the kernel discards the rest

class SocketStream final : public Stream {
 public:
  SocketStream(int fd, bool local) : fd_(fd), local_(local) {
    if (local) return;
    const int on = 1;  // lockstep sends small messages and waits for each answer
    ::setsockopt(fd_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    beyond_posix::give_up_on_a_silent_peer(fd_, kSilence);
  }
  ~SocketStream() override {
    if (received_fd_ >= 0) ::close(received_fd_);
    ::close(fd_);
  }
  SocketStream(const SocketStream&) = delete;
  SocketStream& operator=(const SocketStream&) = delete;

  Result<std::size_t> read(std::span<std::byte> into) noexcept override {
    // A Unix socket wakes a thread in recv() also when there is room to write again; a thread in poll() it does not.
    if (split_ && local_ && !wait_for_bytes()) return system_error("socket read", EAGAIN);
    return receive(into, 0);
  }

  Result<std::size_t> read_now(std::span<std::byte> into) noexcept override {
    auto n = receive(into, MSG_DONTWAIT);
    if (!n && n.error().code == Errc::timeout) return std::size_t{0};
    return n;
  }

  Status write(std::span<const std::byte> head, std::span<const std::byte> tail) noexcept override {
    while (!head.empty() || !tail.empty()) {
      const ssize_t n = tail.empty() ? ::send(fd_, head.data(), head.size(), MSG_NOSIGNAL) : send_both(head, tail);
      if (n < 0) {
        if (errno == EINTR) continue;
        return system_error("socket write", errno);
      }
      const auto done = static_cast<std::size_t>(n);
      const std::size_t of_head = std::min(done, head.size());
      head = head.subspan(of_head);
      tail = tail.subspan(done - of_head);
    }
    return {};
  }

  Result<std::size_t> write_now(std::span<const std::byte> bytes) noexcept override {
    while (!bytes.empty()) {
      const ssize_t n = ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
      if (n >= 0) return static_cast<std::size_t>(n);
      if (errno == EINTR) continue;
      if (errno == EAGAIN || errno == EWOULDBLOCK) return std::size_t{0};
      return system_error("socket write", errno);
    }
    return std::size_t{0};
  }

  void set_patience(Duration patience) noexcept override {
    patience_ = patience;
    const timeval tv = to_timeval(patience);
    ::setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &tv, sizeof tv);
    ::setsockopt(fd_, SOL_SOCKET, SO_SNDTIMEO, &tv, sizeof tv);
  }

  void split() noexcept override { split_ = true; }
  bool local() const noexcept override { return local_; }
  void expect_memory() noexcept override { expects_memory_ = true; }
  Result<Peer> peer() const noexcept override {
    if (!local_) return Error{Errc::not_supported, "peer of this connection"};
    return beyond_posix::peer_of(fd_);
  }
  std::intptr_t handle() const noexcept override { return fd_; }
  void shutdown() noexcept override { ::shutdown(fd_, SHUT_RDWR); }

  Status write_with_memory(std::span<const std::byte> bytes, const SharedMemory& memory) noexcept override {
    if (!local_ || memory.handle() < 0 || bytes.empty())
      return Error{Errc::not_supported, "this connection cannot hand over memory"};
    const int fd = static_cast<int>(memory.handle());
    alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof fd)> control{};
    iovec part{const_cast<std::byte*>(bytes.data()), bytes.size()};
    msghdr message{};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    cmsghdr* item = CMSG_FIRSTHDR(&message);
    item->cmsg_level = SOL_SOCKET;
    item->cmsg_type = SCM_RIGHTS;
    item->cmsg_len = CMSG_LEN(sizeof fd);
    std::memcpy(CMSG_DATA(item), &fd, sizeof fd);
    ssize_t n = 0;
    do n = ::sendmsg(fd_, &message, MSG_NOSIGNAL);
    while (n < 0 && errno == EINTR);
    if (n < 0) return system_error("socket write with memory", errno);
    return write(bytes.subspan(static_cast<std::size_t>(n)), {});
  }

  Result<std::unique_ptr<SharedMemory>> take_memory(MemoryAccess access) override {
    expects_memory_ = false;  // from now on the plain read: the kernel drops handles of a hostile peer
    if (received_fd_ < 0) return Error{Errc::not_found, "peer handed over no memory"};
    return open_shared_memory(std::exchange(received_fd_, -1), access);
  }

 private:
  Result<std::size_t> receive(std::span<std::byte> into, int flags) noexcept {
    for (;;) {
      const ssize_t n =
          expects_memory_ && local_ ? receive_with_handles(into, flags) : ::recv(fd_, into.data(), into.size(), flags);
      if (n > 0) return static_cast<std::size_t>(n);
      if (n == 0) return Error{Errc::closed, "peer closed the connection"};
      if (errno == EINTR) continue;
      return system_error("socket read", errno);
    }
  }

  /// False: no byte came in time.
  bool wait_for_bytes() noexcept {
    pollfd waiting{fd_, POLLIN, 0};
    const timespec limit{static_cast<time_t>(patience_.count() / 1'000'000'000),
                         static_cast<long>(patience_.count() % 1'000'000'000)};
    int n = 0;
    do n = ::ppoll(&waiting, 1, patience_.count() > 0 ? &limit : nullptr, nullptr);
    while (n < 0 && errno == EINTR);
    return n != 0;
  }

  ssize_t send_both(std::span<const std::byte> head, std::span<const std::byte> tail) noexcept {
    std::array<iovec, 2> parts{
        {{const_cast<std::byte*>(head.data()), head.size()}, {const_cast<std::byte*>(tail.data()), tail.size()}}};
    msghdr message{};
    message.msg_iov = parts.data();
    message.msg_iovlen = parts.size();
    return ::sendmsg(fd_, &message, MSG_NOSIGNAL);
  }

  /// Keeps the first handle that ever comes, closes all others.
  ssize_t receive_with_handles(std::span<std::byte> into, int flags) noexcept {
    alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int) * kMaxHandles)> control{};
    iovec part{into.data(), into.size()};
    msghdr message{};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    const ssize_t n = ::recvmsg(fd_, &message, flags | MSG_CMSG_CLOEXEC);
    if (n < 0) return n;
    for (cmsghdr* item = CMSG_FIRSTHDR(&message); item; item = CMSG_NXTHDR(&message, item)) {
      if (item->cmsg_level != SOL_SOCKET || item->cmsg_type != SCM_RIGHTS) continue;
      const std::size_t count = (item->cmsg_len - CMSG_LEN(0)) / sizeof(int);
      for (std::size_t i = 0; i < count; ++i) {
        int fd = -1;
        std::memcpy(&fd, CMSG_DATA(item) + i * sizeof fd, sizeof fd);
        if (received_fd_ < 0)
          received_fd_ = fd;
        else
          ::close(fd);
      }
    }
    return n;
  }

  int fd_;
  bool local_;
  bool split_ = false;
  Duration patience_{};
  bool expects_memory_ = true;
  int received_fd_ = -1;
};

struct Address {
  sockaddr_storage storage{};
  socklen_t size = 0;
  bool local = false;
  const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&storage); }
};

/// A host may have several addresses, tried in the order of the system's preference (RFC 6724).
using Addresses = std::vector<Address>;

Result<Addresses> unix_address(std::string_view path) {
  Address a;
  auto* un = reinterpret_cast<sockaddr_un*>(&a.storage);
  if (path.empty() || path.size() >= sizeof un->sun_path)
    return Error{Errc::bad_argument, "path of a Unix socket is empty or too long", std::int64_t(path.size())};
  un->sun_family = AF_UNIX;
  std::memcpy(un->sun_path, path.data(), path.size());
  a.size = sizeof(sockaddr_un);
  a.local = true;
  return Addresses{a};
}

Result<Addresses> tcp_addresses(std::string_view host_port, bool passive) {
  const auto colon = host_port.rfind(':');
  if (colon == std::string_view::npos || colon == 0 || colon + 1 == host_port.size())
    return Error{Errc::bad_argument, "endpoint is neither unix:PATH nor tcp:HOST:PORT"};
  std::string_view host = host_port.substr(0, colon);
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_NUMERICSERV | (passive ? AI_PASSIVE : 0);
  addrinfo* list = nullptr;
  const int why =
      ::getaddrinfo(std::string(host).c_str(), std::string(host_port.substr(colon + 1)).c_str(), &hints, &list);
  if (why != 0 || !list)
    return Error{why == EAI_SERVICE ? Errc::bad_argument : Errc::not_found, "host or port is unknown", why};
  Addresses all;
  for (const addrinfo* one = list; one; one = one->ai_next) {
    Address& a = all.emplace_back();
    std::memcpy(&a.storage, one->ai_addr, one->ai_addrlen);
    a.size = one->ai_addrlen;
  }
  ::freeaddrinfo(list);
  return all;
}

Result<Addresses> parse_endpoint(std::string_view endpoint, bool passive) {
  if (endpoint.starts_with("unix:")) return unix_address(endpoint.substr(5));
  if (endpoint.starts_with("tcp:")) return tcp_addresses(endpoint.substr(4), passive);
  if (endpoint.find('/') != std::string_view::npos) return unix_address(endpoint);
  return tcp_addresses(endpoint, passive);
}

using Leave = std::function<bool()>;

/// connect() in short turns. The errno; 0: connected.
int connect_in_turns(int fd, const Address& a, Duration patience, const Leave& leave) {
  constexpr timespec kTurn{0, 50'000'000};
  const auto give_up = std::chrono::steady_clock::now() + patience;
  const int flags = ::fcntl(fd, F_GETFL);
  ::fcntl(fd, F_SETFL, flags | O_NONBLOCK);
  int why = ::connect(fd, a.get(), a.size) == 0 ? 0 : errno;
  while (why == EINPROGRESS || why == EINTR) {  // an interrupted connect() goes on, too
    pollfd waiting{fd, POLLOUT, 0};
    if (::ppoll(&waiting, 1, &kTurn, nullptr) > 0) {
      socklen_t size = sizeof why;
      ::getsockopt(fd, SOL_SOCKET, SO_ERROR, &why, &size);
      break;
    }
    if (leave() || std::chrono::steady_clock::now() >= give_up) why = ETIMEDOUT;
  }
  ::fcntl(fd, F_SETFL, flags);
  return why;
}

/// Waits at most `patience`, for a host that does not answer at all.
Result<int> connect_once(const Address& a, Duration patience, const Leave& leave = {}) {
  const int fd = ::socket(a.storage.ss_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return system_error("socket", errno);
  if (leave && !a.local) {
    const int why = connect_in_turns(fd, a, patience, leave);
    if (why == 0) return fd;
    ::close(fd);
    return system_error("nobody answers at this endpoint", why);
  }
  if (leave) patience = std::min<Duration>(patience, std::chrono::milliseconds(200));
  const timeval limit = to_timeval(std::max(patience, Duration{1'000'000}));
  ::setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit);
  int result = 0;
  do result = ::connect(fd, a.get(), a.size);
  while (result != 0 && errno == EINTR);
  int why = result == 0 ? 0 : errno;
  if (why == EINPROGRESS) why = ETIMEDOUT;
  const timeval for_ever{};
  ::setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &for_ever, sizeof for_ever);
  if (why == 0) return fd;
  ::close(fd);
  return system_error("nobody answers at this endpoint", why);
}

/// True if a listener may appear there a little later.
bool may_come(const Error& e) { return e.code == Errc::closed || e.code == Errc::not_found || e.code == Errc::timeout; }

/// Tries one after the other; the time goes in equal parts to those that are left. Answers the first error, but prefers
/// that of an address where a listener may appear to that of an unreachable network.
Result<int> connect_any(const Addresses& all, std::chrono::steady_clock::time_point give_up, const Leave& leave) {
  std::optional<Error> first;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Duration left = give_up - std::chrono::steady_clock::now();
    auto fd = connect_once(all[i], left / static_cast<std::int64_t>(all.size() - i), leave);
    if (fd) return fd;
    if (!first || (!may_come(*first) && may_come(fd.error()))) first = fd.error();
  }
  return *first;
}

class SocketListener final : public Listener {
 public:
  SocketListener(int fd, std::string endpoint, std::string path)
      : fd_(fd), endpoint_(std::move(endpoint)), path_(std::move(path)) {}
  ~SocketListener() override {
    ::close(fd_);
    if (!path_.empty()) ::unlink(path_.c_str());
  }
  SocketListener(const SocketListener&) = delete;
  SocketListener& operator=(const SocketListener&) = delete;

  Result<std::unique_ptr<Stream>> accept(Duration patience) override {
    const timespec limit{static_cast<time_t>(patience.count() / 1'000'000'000),
                         static_cast<long>(patience.count() % 1'000'000'000)};
    for (;;) {
      pollfd waiting{fd_, POLLIN, 0};
      const int n = ::ppoll(&waiting, 1, &limit, nullptr);
      if (n == 0) return Error{Errc::timeout, "nobody connected"};
      const int fd = n < 0 ? -1 : ::accept4(fd_, nullptr, nullptr, SOCK_CLOEXEC);
      if (fd >= 0) return std::unique_ptr<Stream>(new SocketStream(fd, !path_.empty()));
      if (errno != EINTR && errno != EAGAIN && errno != ECONNABORTED) return system_error("accept", errno);
    }
  }
  const std::string& endpoint() const override { return endpoint_; }
  std::intptr_t handle() const noexcept override { return fd_; }

 private:
  int fd_;
  std::string endpoint_;
  std::string path_;  // Unix: the file to remove
};

/// A socket file without a listener was left by a process that died.
void remove_dead_file(const Address& a, const char* path) {
  struct stat info {};
  if (::lstat(path, &info) != 0 || !S_ISSOCK(info.st_mode)) return;
  auto fd = connect_once(a, std::chrono::seconds(1));
  if (fd)
    ::close(*fd);
  else if (fd.error().detail == ECONNREFUSED)
    ::unlink(path);
}

std::string tcp_endpoint_of(int fd) {
  sockaddr_storage own{};
  socklen_t size = sizeof own;
  ::getsockname(fd, reinterpret_cast<sockaddr*>(&own), &size);
  std::array<char, INET6_ADDRSTRLEN + 32> host{};  // with the interface's name
  std::array<char, 8> port{};
  ::getnameinfo(reinterpret_cast<sockaddr*>(&own), size, host.data(), host.size(), port.data(), port.size(),
                NI_NUMERICHOST | NI_NUMERICSERV);
  const bool v6 = own.ss_family == AF_INET6;
  return std::string("tcp:") + (v6 ? "[" : "") + host.data() + (v6 ? "]:" : ":") + port.data();
}

Result<std::unique_ptr<Listener>> listen_at(const Address& address) {
  const int fd = ::socket(address.storage.ss_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return system_error("socket", errno);
  std::string path;
  if (address.local) {
    path = reinterpret_cast<const sockaddr_un*>(&address.storage)->sun_path;
    remove_dead_file(address, path.c_str());
  } else {
    const int on = 1;
    ::setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  }
  const bool bound = path.empty() ? ::bind(fd, address.get(), address.size) == 0
                                  : beyond_posix::bind_for_its_owner(fd, address.get(), address.size);
  if (!bound || ::listen(fd, 4) != 0) {
    const int why = errno;
    ::close(fd);
    return system_error("cannot listen at this endpoint", why);
  }
  std::string own = path.empty() ? tcp_endpoint_of(fd) : "unix:" + path;
  return std::unique_ptr<Listener>(new SocketListener(fd, std::move(own), std::move(path)));
}

}  // namespace

Result<std::unique_ptr<Stream>> connect_stream(std::string_view endpoint, Duration patience) {
  return connect_stream_until(endpoint, patience, {});
}

Result<std::unique_ptr<Stream>> connect_stream_until(std::string_view endpoint, Duration patience,
                                                     const std::function<bool()>& leave) {
  const auto addresses = parse_endpoint(endpoint, false);
  if (!addresses) return addresses.error();
  const auto give_up = std::chrono::steady_clock::now() + patience;
  for (;;) {
    auto fd = connect_any(*addresses, give_up, leave);
    if (fd) return std::unique_ptr<Stream>(new SocketStream(*fd, addresses->front().local));
    if (leave && leave()) return Error{Errc::timeout, "connecting was given up"};
    if (!may_come(fd.error()) || std::chrono::steady_clock::now() >= give_up) return fd.error();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

Result<std::unique_ptr<Listener>> listen_stream(std::string_view endpoint) {
  const auto addresses = parse_endpoint(endpoint, true);
  if (!addresses) return addresses.error();
  std::optional<Error> first;
  for (const Address& address : *addresses) {
    auto listener = listen_at(address);
    if (listener) return listener;
    if (!first) first = listener.error();
  }
  return *first;
}

Status wait_ready(std::span<Waiting> items, Duration patience) {
  std::array<pollfd, kMaxWaiting> fds{};
  if (items.size() > fds.size()) return Error{Errc::bad_argument, "too many streams to wait for"};
  for (std::size_t i = 0; i < items.size(); ++i)
    fds[i] = {static_cast<int>(items[i].handle), static_cast<short>(items[i].room ? POLLOUT : POLLIN), 0};
  const timespec limit{static_cast<time_t>(patience.count() / 1'000'000'000),
                       static_cast<long>(patience.count() % 1'000'000'000)};
  const int n = ::ppoll(fds.data(), static_cast<nfds_t>(items.size()), &limit, nullptr);
  if (n < 0 && errno != EINTR) return system_error("poll", errno);
  for (std::size_t i = 0; i < items.size(); ++i) items[i].ready = n > 0 && fds[i].revents != 0;
  return {};
}

std::string peer_address(const Stream& stream) {
  sockaddr_storage peer{};
  socklen_t size = sizeof peer;
  if (::getpeername(static_cast<int>(stream.handle()), reinterpret_cast<sockaddr*>(&peer), &size) != 0) return "";
  if (peer.ss_family != AF_INET && peer.ss_family != AF_INET6) return "";
  std::array<char, INET6_ADDRSTRLEN + 32> host{};  // with the interface's name
  if (::getnameinfo(reinterpret_cast<sockaddr*>(&peer), size, host.data(), host.size(), nullptr, 0, NI_NUMERICHOST) !=
      0)
    return "";
  return host.data();
}

Result<std::pair<std::unique_ptr<Stream>, std::unique_ptr<Stream>>> stream_pair() {
  std::array<int, 2> fds{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, fds.data()) != 0) return system_error("socketpair", errno);
  return std::pair<std::unique_ptr<Stream>, std::unique_ptr<Stream>>(std::make_unique<SocketStream>(fds[0], true),
                                                                     std::make_unique<SocketStream>(fds[1], true));
}

}  // namespace sinew::hal
