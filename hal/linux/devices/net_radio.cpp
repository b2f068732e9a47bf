#include "hal/linux/devices/net_radio.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <vector>

#include "hal/linux/open_error.hpp"
#include "hal/linux/run_dir.hpp"
#include "wire/net_link.hpp"

namespace sinew::hal {
namespace {

using namespace std::chrono_literals;
using wire::NetLinkKind;

constexpr Duration kSeekEvery = 200ms;
constexpr Duration kCrowdedPause = 5ms;  // without room for more, what comes meanwhile waits in the socket or is lost

int seqpacket_socket() noexcept { return socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0); }

/// A socket that is connected to the program; negative: there is none (errno).
int connected_to_net(const std::string& path) noexcept {
  sockaddr_un to{};
  to.sun_family = AF_UNIX;
  if (path.size() >= sizeof to.sun_path) return errno = ENAMETOOLONG, -1;
  std::copy(path.begin(), path.end(), to.sun_path);
  const int fd = seqpacket_socket();
  if (fd < 0) return -1;
  if (connect(fd, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0) return fd;
  const int error = errno;
  close(fd);
  return errno = error, -1;
}

bool send_empty(int fd, NetLinkKind kind) noexcept {
  std::array<std::uint8_t, wire::kNetLinkHeadBytes> bytes{};
  const std::size_t size = wire::write_net_link({kind, 0, 0, 0, {}}, bytes);
  return ::send(fd, bytes.data(), size, MSG_DONTWAIT | MSG_NOSIGNAL) == static_cast<ssize_t>(size);
}

bool is_net_name(std::string_view name) {
  return !name.empty() && name.size() <= 40 && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
}

}  // namespace

Result<std::string> net_socket_path(const std::string& name, std::string& why) {
  if (!is_net_name(name)) {
    why = "'" + name + "' is no robot's name: letters, digits, _ and -, at most 40";
    return Error{Errc::bad_argument, "a robot's name"};
  }
  std::string folder;
  if (auto ok = run_dir(folder); !ok) {
    why = folder + ": " + to_string(ok.error().code);
    return ok.error();
  }
  std::string path = folder + "/" + name + ".net";
  if (path.size() >= sizeof sockaddr_un::sun_path) {
    why = path + ": longer than a socket's path may be";
    return Error{Errc::bad_argument, "a socket's path"};
  }
  return path;
}

Result<std::string> ask_net(const std::string& name, Duration patience, std::string& why) {
  const auto path = net_socket_path(name, why);
  if (!path) return path.error();
  const int fd = connected_to_net(*path);
  if (fd < 0) {
    why = "no sinew net runs for the robot '" + name + "'";
    return Error{Errc::not_found, "sinew net", errno};
  }
  std::vector<std::uint8_t> bytes(wire::kNetLinkHeadBytes + wire::kNetLinkMostText);
  pollfd ready{fd, POLLIN, 0};
  Result<std::string> result = Error{Errc::timeout, "sinew net"};
  why = "sinew net of '" + name + "' does not answer";
  if (send_empty(fd, NetLinkKind::ask) && poll(&ready, 1, static_cast<int>(patience / 1ms)) == 1) {
    const ssize_t n = recv(fd, bytes.data(), bytes.size(), MSG_DONTWAIT);
    const auto packet = n > 0 ? wire::read_net_link({bytes.data(), static_cast<std::size_t>(n)}) : std::nullopt;
    if (packet && packet->kind == NetLinkKind::answer) {
      result = std::string(packet->payload.begin(), packet->payload.end());
      why.clear();
    }
  }
  close(fd);
  return result;
}

Result<std::unique_ptr<Radio>> NetRadio::open(const std::string& name, Os& os, std::string& why) {
  std::unique_ptr<NetRadio> radio(new NetRadio(name, os));
  auto path = net_socket_path(name, why);
  if (!path) return path.error();
  radio->path_ = std::move(*path);
  radio->socket_ = seqpacket_socket();
  radio->stop_ = eventfd(0, EFD_CLOEXEC);
  if (radio->socket_ < 0 || radio->stop_ < 0) {
    why = "no socket: " + errno_text(errno);
    return Error{Errc::io, "socket", errno};
  }
  ThreadOptions options;
  options.name = "radio", options.stack_bytes = std::size_t{128} * 1024;
  auto thread = os.start_thread(options, [r = radio.get()] { r->run(); });
  if (!thread) {
    why = "its thread does not start";
    return thread.error();
  }
  radio->thread_ = std::move(*thread);
  return std::unique_ptr<Radio>(std::move(radio));
}

NetRadio::~NetRadio() {
  if (thread_) {
    const std::uint64_t one = 1;
    while (write(stop_, &one, sizeof one) < 0 && errno == EINTR) {
    }
    thread_->join();
  }
  for (const int fd : {socket_, stop_})
    if (fd >= 0) close(fd);
}

// ---- the robot's threads

Result<bool> NetRadio::read(msg::Datagram& out) noexcept {
  if (ring_.size() == 0) return false;
  out = ring_.at(0);
  ring_.pop();
  return true;
}

Status NetRadio::not_sent(Errc code, const char* where, int error) noexcept {
  tx_lost_.add();
  return Error{code, where, error};
}

Status NetRadio::send(std::span<const std::uint8_t> bytes) noexcept {
  if (bytes.empty() || bytes.size() > msg::kMaxDatagramBytes) return Error{Errc::bad_argument, "a datagram's size"};
  if (!connected_.load(std::memory_order_relaxed)) return not_sent(Errc::closed, "no sinew net", 0);
  std::array<std::uint8_t, wire::kNetLinkHeadBytes + msg::kMaxDatagramBytes> packet;
  const std::size_t size = wire::write_net_link({NetLinkKind::say, 0, 0, 0, bytes}, packet);
  if (::send(socket_, packet.data(), size, MSG_DONTWAIT | MSG_NOSIGNAL) < 0) {
    const int error = errno;
    const bool full = error == EAGAIN || error == ENOBUFS || error == ENOMEM || error == EINTR;
    return not_sent(full ? Errc::busy : Errc::closed, "sinew net", error);
  }
  sent_.add(), sent_bytes_.add(static_cast<std::uint32_t>(bytes.size()));
  return {};
}

RadioStats NetRadio::stats() const noexcept {
  RadioStats out;
  out.received = received_.value(), out.received_bytes = received_bytes_.value();
  out.sent = sent_.value(), out.sent_bytes = sent_bytes_.value();
  out.rx_lost = rx_lost_.value(), out.rx_other = rx_other_.value(), out.tx_lost = tx_lost_.value();
  return out;
}

std::string NetRadio::trouble() const {
  if (!connected_.load(std::memory_order_relaxed)) {
    const bool starts = !was_connected_.load(std::memory_order_relaxed) && os_.now() - opened_ < kStarts;
    return "sinew net of '" + name_ + (starts ? "' is starting" : "' does not run: no DDS");
  }
  const std::string text = program_trouble_.get();
  return text.empty() ? "" : "sinew net: " + text;
}

// ---- its own thread

void NetRadio::run() noexcept {
  Time seek = os_.now();
  for (;;) {
    bool connected = connected_.load(std::memory_order_relaxed);
    if (!connected && os_.now() >= seek) connected = connect_now(), seek = os_.now() + kSeekEvery;
    const bool full = ring_.full();
    std::array<pollfd, 2> fds{{{stop_, POLLIN, 0}, {connected && !full ? socket_ : -1, POLLIN, 0}}};
    const Duration rest = full ? kCrowdedPause : connected ? Duration(1s) : std::max(seek - os_.now(), Duration(1ms));
    if (poll(fds.data(), fds.size(), static_cast<int>((rest + 999us) / 1ms)) < 0) fds[0].revents = fds[1].revents = 0;
    if (fds[0].revents != 0) return;
    if (fds[1].revents != 0) receive();
  }
}

bool NetRadio::connect_now() noexcept {
  const int fd = connected_to_net(path_);
  if (fd < 0) return false;
  const bool ok = send_empty(fd, NetLinkKind::hello) && dup3(fd, socket_, O_CLOEXEC) >= 0;
  close(fd);
  if (ok) program_trouble_.set({}), was_connected_.store(true, std::memory_order_relaxed);
  connected_.store(ok, std::memory_order_relaxed);
  return ok;
}

/// Behind the same number is a socket without a peer then: a send() that runs now is refused.
void NetRadio::lose() noexcept {
  connected_.store(false, std::memory_order_relaxed);
  const int fd = seqpacket_socket();
  if (fd < 0) return;  // the old one has no peer either
  dup3(fd, socket_, O_CLOEXEC);
  close(fd);
}

void NetRadio::receive() noexcept {
  bool any = false;
  while (!ring_.full()) {
    const ssize_t n = recv(socket_, packet_.data(), packet_.size(), MSG_DONTWAIT);
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) break;
    if (n <= 0) {  // no packet is empty: the program has ended
      lose();
      break;
    }
    const auto packet = wire::read_net_link({packet_.data(), static_cast<std::size_t>(n)});
    if (packet && packet->kind == NetLinkKind::state) {
      program_trouble_.set(std::string(packet->payload.begin(), packet->payload.end()));
      continue;
    }
    if (!packet || packet->kind != NetLinkKind::heard) {
      rx_other_.add();
      continue;
    }
    // The program's clock is this machine's; the robot's own may run at another pace.
    timespec ts{};
    clock_gettime(CLOCK_MONOTONIC, &ts);
    const std::int64_t age_ns =
        std::max<std::int64_t>(0, std::int64_t{ts.tv_sec} * 1'000'000'000 + ts.tv_nsec - packet->stamp_ns);
    const auto most_ns = static_cast<double>(std::min<std::int64_t>(age_ns, 1'000'000'000));
    incoming_.stamp = os_.now() - Duration(static_cast<std::int64_t>(most_ns * os_.rate()));
    incoming_.sender = packet->sender;
    incoming_.port = 0;
    incoming_.lost = packet->lost;
    if (packet->lost != 0) rx_lost_.add(packet->lost);
    const auto size = static_cast<std::uint32_t>(packet->payload.size());
    std::copy(packet->payload.begin(), packet->payload.end(), incoming_.data.begin());
    // The bytes behind the datagram's are 0: equal datagrams are equal messages.
    if (size < incoming_.size) std::fill(&incoming_.data[size], &incoming_.data[size] + (incoming_.size - size), 0);
    incoming_.size = size;
    static_cast<void>(ring_.push(incoming_));
    received_.add(), received_bytes_.add(size);
    any = true;
  }
  if (any) wake_.ring();
}

}  // namespace sinew::hal
