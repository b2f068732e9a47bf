#include <algorithm>
#include <array>
#include <climits>
#include <cstring>
#include <string>

#include "hal/platform.hpp"
#include "hal/wince_stub/coredll.hpp"

namespace sinew::hal {
namespace {

using namespace ce;

constexpr std::int64_t kNsPerUs = 1000, kUsPerSecond = 1'000'000;
constexpr int kMostAtOnce = INT_MAX / 2;

Error system_error(const char* where, int why) {
  switch (why) {
    case kConnectionReset:
    case kConnectionAborted:
    case kConnectionRefused:
    case kNotConnected:
    case kShutDown:
      return {Errc::closed, where, why};
    case kWouldBlock:
    case kTimedOut:
      return {Errc::timeout, where, why};
    case kHostNotFound:
    case kHostUnreachable:
      return {Errc::not_found, where, why};
    case kAddressInUse:
      return {Errc::busy, where, why};
    case kAccess:
      return {Errc::denied, where, why};
    case kNoBuffers:
      return {Errc::out_of_memory, where, why};
    default:
      return {Errc::io, where, why};
  }
}

/// Starts Winsock 2.2, from the first use until the process ends. 0: it is there.
int winsock() {
  static const int why = [] {
    WinsockData data{};
    return WSAStartup(0x0202, &data);
  }();
  return why;
}

enum class Until : std::uint8_t { readable, writable, connected };

/// Waits for one socket; zero patience: for ever. 1: ready; 0: time-out; negative: failed.
int wait_for(Socket s, Until what, Duration patience) noexcept {
  SocketSet ready{1, {s}}, failed{1, {s}};
  const std::int64_t us = (patience.count() + kNsPerUs - 1) / kNsPerUs;
  const TimeVal limit{static_cast<std::int32_t>(us / kUsPerSecond), static_cast<std::int32_t>(us % kUsPerSecond)};
  const bool read = what == Until::readable;
  const int n = select(0, read ? &ready : nullptr, read ? nullptr : &ready,
                       what == Until::connected ? &failed : nullptr, patience.count() > 0 ? &limit : nullptr);
  // Only the third set reports a connection that failed.
  return n > 0 && what == Until::connected && ready.count == 0 ? -1 : n;
}

void set_blocking(Socket s, bool on) noexcept {
  std::uint32_t off = on ? 0 : 1;
  ioctlsocket(s, kFionbio, &off);
}

template <class Value>
void set_option(Socket s, int level, int name, Value value) noexcept {
  setsockopt(s, level, name, reinterpret_cast<const char*>(&value), sizeof value);
}

/// Every socket is non-blocking, and waits in select(): so the time-outs are ours, and both directions are independent.
class TcpStream final : public Stream {
 public:
  explicit TcpStream(Socket s) : socket_(s) {
    set_blocking(s, false);
    set_option(s, kProtocolTcp, kTcpNoDelay, int{1});  // lockstep sends small messages and waits for each answer
    set_option(s, kSocketLevel, kKeepAlive, int{1});
  }
  ~TcpStream() override { closesocket(socket_); }
  TcpStream(const TcpStream&) = delete;
  TcpStream& operator=(const TcpStream&) = delete;

  Result<std::size_t> read(std::span<std::byte> into) noexcept override {
    for (;;) {
      const int n = receive(into);
      if (n > 0) return static_cast<std::size_t>(n);
      if (n == 0 && !into.empty()) return Error{Errc::closed, "the peer has closed the connection"};
      if (n == 0) return std::size_t{0};
      if (const int why = WSAGetLastError(); why != kWouldBlock) return system_error("socket read", why);
      const int ready = wait_for(socket_, Until::readable, patience_);
      if (ready == 0) return Error{Errc::timeout, "socket read"};
      if (ready < 0) return system_error("select", WSAGetLastError());
    }
  }

  Result<std::size_t> read_now(std::span<std::byte> into) noexcept override {
    const int n = receive(into);
    if (n > 0) return static_cast<std::size_t>(n);
    if (n == 0 && !into.empty()) return Error{Errc::closed, "the peer has closed the connection"};
    if (n == 0) return std::size_t{0};
    const int why = WSAGetLastError();
    if (why == kWouldBlock) return std::size_t{0};
    return system_error("socket read", why);
  }

  Status write(std::span<const std::byte> head, std::span<const std::byte> tail) noexcept override {
    while (!head.empty() || !tail.empty()) {
      auto n = send_both(head, tail);
      if (!n) return n.error();
      if (*n == 0) {
        const int ready = wait_for(socket_, Until::writable, patience_);
        if (ready == 0) return Error{Errc::timeout, "socket write"};
        if (ready < 0) return system_error("select", WSAGetLastError());
      }
      const std::size_t of_head = std::min(*n, head.size());
      head = head.subspan(of_head);
      tail = tail.subspan(*n - of_head);
    }
    return {};
  }

  Result<std::size_t> write_now(std::span<const std::byte> bytes) noexcept override {
    return bytes.empty() ? Result<std::size_t>(std::size_t{0}) : send_both(bytes, {});
  }

  void set_patience(Duration patience) noexcept override { patience_ = patience; }
  bool local() const noexcept override { return false; }
  Status write_with_memory(std::span<const std::byte>, const SharedMemory&) noexcept override {
    return Error{Errc::not_supported, "memory over TCP"};
  }
  Result<std::unique_ptr<SharedMemory>> take_memory(MemoryAccess) override {
    return Error{Errc::not_found, "memory over TCP"};
  }
  void shutdown() noexcept override { ce::shutdown(socket_, kShutdownBoth); }

 private:
  int receive(std::span<std::byte> into) noexcept {
    const auto room = static_cast<int>(std::min<std::size_t>(into.size(), kMostAtOnce));
    return recv(socket_, reinterpret_cast<char*>(into.data()), room, 0);
  }

  /// 0: no room now.
  Result<std::size_t> send_both(std::span<const std::byte> head, std::span<const std::byte> tail) noexcept {
    const auto buffer = [](std::span<const std::byte> b) {
      auto* at = const_cast<char*>(reinterpret_cast<const char*>(b.data()));  // the type of the call, which only reads
      return Buffer{static_cast<std::uint32_t>(std::min<std::size_t>(b.size(), kMostAtOnce)), at};
    };
    std::array<Buffer, 2> both{buffer(head), buffer(tail)};
    if (head.size() > kMostAtOnce) both[1].bytes = 0;
    const bool first = both[0].bytes > 0, second = both[1].bytes > 0;
    Dword sent = 0;
    Buffer* from = first ? both.data() : both.data() + 1;
    if (WSASend(socket_, from, Dword{first} + Dword{second}, &sent, 0, nullptr, nullptr) == 0) return std::size_t{sent};
    const int why = WSAGetLastError();
    if (why == kWouldBlock) return std::size_t{0};
    return system_error("socket write", why);
  }

  Socket socket_;
  Duration patience_{0};
};

struct Address {
  SocketAddress storage{};
  int size = 0;
};

Result<Address> address_of(std::string_view endpoint, bool passive) {
  if (endpoint.starts_with("unix:") || (!endpoint.starts_with("tcp:") && endpoint.find('/') != endpoint.npos))
    return Error{Errc::not_supported, "Unix sockets: not on this system; tcp:HOST:PORT is"};
  const std::string_view text = endpoint.starts_with("tcp:") ? endpoint.substr(4) : endpoint;
  const auto colon = text.rfind(':');
  if (colon == text.npos || colon == 0 || colon + 1 == text.size())
    return Error{Errc::bad_argument, "endpoint is not tcp:HOST:PORT"};
  const std::string_view port = text.substr(colon + 1);
  if (port.size() > 5 || port.find_first_not_of("0123456789") != port.npos)
    return Error{Errc::bad_argument, "the port is no number"};
  std::string_view host = text.substr(0, colon);
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
  AddressInfo hints{};
  hints.family = kUnspecified, hints.type = kStreamSocket, hints.flags = passive ? kPassive : 0;
  AddressInfo* list = nullptr;
  const int why = getaddrinfo(std::string(host).c_str(), std::string(port).c_str(), &hints, &list);
  if (why != 0 || list == nullptr) return Error{Errc::not_found, "host is unknown", why};
  Address a;
  a.size = static_cast<int>(std::min(list->address_bytes, sizeof a.storage));
  std::memcpy(&a.storage, list->address, static_cast<std::size_t>(a.size));
  freeaddrinfo(list);
  return a;
}

Result<Socket> connect_once(const Address& a, Duration patience) {
  const Socket s = socket(a.storage.family, kStreamSocket, kProtocolTcp);
  if (s == kInvalidSocket) return system_error("socket", WSAGetLastError());
  set_blocking(s, false);
  int why = connect(s, &a.storage, a.size) == 0 ? 0 : WSAGetLastError();
  if (why == kWouldBlock) {
    const int ready = wait_for(s, Until::connected, std::max(patience, Duration{1'000'000}));
    int bytes = sizeof why;
    why = ready == 0 ? kTimedOut : ready > 0 ? 0 : kConnectionRefused;
    int told = 0;
    if (ready < 0 && getsockopt(s, kSocketLevel, kSocketErrorOption, reinterpret_cast<char*>(&told), &bytes) == 0 &&
        told)
      why = told;
  }
  if (why == 0) return s;
  closesocket(s);
  return system_error("nobody answers at this endpoint", why);
}

class TcpListener final : public Listener {
 public:
  TcpListener(Socket s, std::string endpoint) : socket_(s), endpoint_(std::move(endpoint)) {}
  ~TcpListener() override { closesocket(socket_); }
  TcpListener(const TcpListener&) = delete;
  TcpListener& operator=(const TcpListener&) = delete;

  Result<std::unique_ptr<Stream>> accept(Duration patience) override {
    // Zero means no patience here, but for ever in wait_for().
    const int ready = wait_for(socket_, Until::readable, std::max(patience, Duration{1}));
    if (ready == 0) return Error{Errc::timeout, "nobody connected"};
    const Socket s = ready < 0 ? kInvalidSocket : ce::accept(socket_, nullptr, nullptr);
    if (s == kInvalidSocket) return system_error("accept", WSAGetLastError());
    return std::unique_ptr<Stream>(new TcpStream(s));
  }
  const std::string& endpoint() const override { return endpoint_; }

 private:
  Socket socket_;
  std::string endpoint_;
};

std::string endpoint_of(Socket s) {
  SocketAddress own{};
  int size = sizeof own;
  std::array<char, 64> host{};
  std::array<char, 8> port{};
  if (getsockname(s, &own, &size) != 0 ||
      getnameinfo(&own, size, host.data(), host.size(), port.data(), port.size(), kNumericHost | kNumericService) != 0)
    return "tcp:?";
  const bool v6 = std::strchr(host.data(), ':') != nullptr;
  return std::string("tcp:") + (v6 ? "[" : "") + host.data() + (v6 ? "]:" : ":") + port.data();
}

}  // namespace

Result<std::unique_ptr<Stream>> connect_stream(std::string_view endpoint, Duration patience) {
  if (const int why = winsock(); why != 0) return Error{Errc::not_supported, "WSAStartup", why};
  auto address = address_of(endpoint, false);
  if (!address) return address.error();
  Os& os = system_os();
  const Time give_up = os.now() + patience;
  for (;;) {
    auto s = connect_once(*address, give_up - os.now());
    if (s) return std::unique_ptr<Stream>(new TcpStream(*s));
    const Errc code = s.error().code;
    const bool may_come = code == Errc::closed || code == Errc::not_found || code == Errc::timeout;
    if (!may_come || os.now() >= give_up) return s.error();
    os.sleep_until(os.now() + Duration{5'000'000});
  }
}

Result<std::unique_ptr<Listener>> listen_stream(std::string_view endpoint) {
  if (const int why = winsock(); why != 0) return Error{Errc::not_supported, "WSAStartup", why};
  auto address = address_of(endpoint, true);
  if (!address) return address.error();
  const Socket s = socket(address->storage.family, kStreamSocket, kProtocolTcp);
  if (s == kInvalidSocket) return system_error("socket", WSAGetLastError());
  set_option(s, kSocketLevel, kExclusiveAddress, int{1});  // otherwise any program may listen at the same port
  if (bind(s, &address->storage, address->size) != 0 || listen(s, 4) != 0) {
    const int why = WSAGetLastError();
    closesocket(s);
    return system_error("cannot listen at this endpoint", why);
  }
  return std::unique_ptr<Listener>(new TcpListener(s, endpoint_of(s)));
}

}  // namespace sinew::hal
