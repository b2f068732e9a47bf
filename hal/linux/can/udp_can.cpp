#include "hal/linux/can/udp_can.hpp"

#include <arpa/inet.h>
#include <net/if.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>

#include "wire/dronecan_udp.hpp"

namespace sinew::hal {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kUdpBatch = 16;
constexpr int kUdpReceiveBytes = 1 << 20;

/// "B", "239.65.82.B", each with ":INTERFACE".
bool read_address(std::string_view text, unsigned& bus, std::string& interface) {
  if (const std::size_t colon = text.find(':'); colon != std::string_view::npos) {
    interface = text.substr(colon + 1);
    text = text.substr(0, colon);
  }
  constexpr std::string_view kPrefix = "239.65.82.";
  if (text.starts_with(kPrefix)) text.remove_prefix(kPrefix.size());
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), bus);
  return error == std::errc() && end == text.data() + text.size() && bus <= 255 && !interface.empty();
}

}  // namespace

struct UdpCanBus::Batch {
  explicit Batch(Time now) : realtime(now) {
    for (std::size_t i = 0; i < kUdpBatch; ++i) {
      parts[i] = {packets[i].data(), packets[i].size()};
      heads[i].msg_hdr.msg_iov = &parts[i];
      heads[i].msg_hdr.msg_iovlen = 1;
      heads[i].msg_hdr.msg_name = &from[i];
    }
  }
  // One byte more than a packet may have, to detect longer ones.
  std::array<std::array<std::uint8_t, wire::kDronecanUdpMax + 1>, kUdpBatch> packets{};
  alignas(cmsghdr) std::array<std::array<std::byte, 128>, kUdpBatch> control{};
  std::array<sockaddr_in, kUdpBatch> from{};
  std::array<iovec, kUdpBatch> parts{};
  std::array<mmsghdr, kUdpBatch> heads{};
  std::size_t next = 0, count = 0;
  Time read_at;
  RealtimeStamps realtime;
};

UdpCanBus::UdpCanBus(const CanSpec& spec, Os& os, std::shared_ptr<FdWatch> watch)
    : CanPort(spec, os, std::move(watch)) {}

Result<std::unique_ptr<CanBus>> UdpCanBus::open(const CanSpec& spec, Os& os, std::shared_ptr<FdWatch> watch,
                                                std::string& why) {
  why.clear();
  std::unique_ptr<UdpCanBus> bus(new UdpCanBus(spec, os, std::move(watch)));
  unsigned number = 0;
  if (!read_address(spec.address, number, bus->interface_)) {
    why = "'" + spec.address + "' is no bus: a number 0..255 or 239.65.82.NUMBER, and :INTERFACE if it is not to be lo";
    return Error{Errc::bad_argument, "address"};
  }
  bus->group_.sin_family = AF_INET;
  bus->group_.sin_port = htons(wire::kDronecanUdpPort);
  bus->group_.sin_addr.s_addr = htonl(wire::kDronecanUdpGroup | number);
  if (if_nametoindex(bus->interface_.c_str()) == 0) {
    why = "there is no interface '" + bus->interface_ + "' ('ip link' lists them)";
    return Error{Errc::not_found, "interface", errno};
  }
  if (const Status opened = bus->open_sockets(why); !opened) {
    why = spec.address + ": " + opened.error().where + ": " + std::strerror(static_cast<int>(opened.error().detail)) +
          (opened.error().detail == ENODEV ? " (is the interface up?)" : "");
    return opened.error();
  }
  return std::unique_ptr<CanBus>(std::move(bus));
}

UdpCanBus::~UdpCanBus() {
  if (in_ >= 0) watch_->remove(in_), close(in_);
  if (out_ >= 0) close(out_);
}

Status UdpCanBus::open_sockets(std::string& /*why*/) {
  const auto failed = [](const char* where) -> Status { return Error{Errc::io, where, errno}; };
  in_ = socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  out_ = socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (in_ < 0 || out_ < 0) return failed("socket");
  const int on = 1, off = 0, bytes = kUdpReceiveBytes;
  if (setsockopt(in_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) != 0) return failed("SO_REUSEADDR");
  // Bound to the group itself: this keeps frames of other buses, which use the same port, out.
  if (bind(in_, reinterpret_cast<const sockaddr*>(&group_), sizeof group_) != 0) return failed("bind");
  if (setsockopt(in_, IPPROTO_IP, IP_MULTICAST_ALL, &off, sizeof off) != 0) return failed("IP_MULTICAST_ALL");
  if (setsockopt(in_, SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on) != 0) return failed("SO_RXQ_OVFL");
  if (setsockopt(in_, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on) != 0) return failed("SO_TIMESTAMPNS");
  if (setsockopt(in_, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes) != 0) return failed("SO_RCVBUF");
  if (const Status joined = join(); !joined) return joined;
  if (connect(out_, reinterpret_cast<const sockaddr*>(&group_), sizeof group_) != 0) return failed("connect");
  sockaddr_in own{};
  socklen_t size = sizeof own;
  if (getsockname(out_, reinterpret_cast<sockaddr*>(&own), &size) != 0) return failed("getsockname");
  own_port_ = own.sin_port, own_address_ = own.sin_addr.s_addr;
  batch_ = std::make_unique<Batch>(os_.now());
  return watch_->add(in_, line_);
}

Status UdpCanBus::join() {
  ip_mreqn where{};
  where.imr_multiaddr = group_.sin_addr;
  where.imr_ifindex = static_cast<int>(if_nametoindex(interface_.c_str()));
  if (where.imr_ifindex == 0) return Error{Errc::not_found, "interface", ENODEV};
  if (setsockopt(in_, IPPROTO_IP, IP_ADD_MEMBERSHIP, &where, sizeof where) != 0 && errno != EADDRINUSE)
    return Error{Errc::io, "IP_ADD_MEMBERSHIP", errno};
  if (setsockopt(out_, IPPROTO_IP, IP_MULTICAST_IF, &where, sizeof where) != 0)
    return Error{Errc::io, "IP_MULTICAST_IF", errno};
  return {};
}

Status UdpCanBus::set_filters(std::span<const CanFilter> filters) {
  filters_.assign(filters.begin(), filters.end());
  return {};
}

Result<bool> UdpCanBus::read(msg::CanFrame& out) noexcept {
  for (;;) {
    if (batch_->next == batch_->count) {
      const auto filled = fill();
      if (!filled || !*filled) return filled;
    }
    if (take(batch_->next++, out)) return true;
  }
}

Result<bool> UdpCanBus::fill() noexcept {
  Batch& b = *batch_;
  b.next = b.count = 0;
  for (std::size_t i = 0; i < kUdpBatch; ++i) {
    b.heads[i].msg_hdr.msg_control = b.control[i].data();
    b.heads[i].msg_hdr.msg_controllen = b.control[i].size();
    b.heads[i].msg_hdr.msg_namelen = sizeof b.from[i];
  }
  const Time asked = os_.now();
  const int n = recvmmsg(in_, b.heads.data(), kUdpBatch, MSG_DONTWAIT, nullptr);
  const int error = n < 0 ? errno : 0;
  const ClockReading clocks = read_clocks(os_);
  b.read_at = clocks.before;
  b.realtime.begin(clocks);
  if (n > 0) {
    b.count = static_cast<std::size_t>(n);
    return true;
  }
  if (error == EAGAIN) b.realtime.drained(asked);
  if (error == 0 || error == EAGAIN || error == EINTR) return false;
  return Error{error == ENETDOWN ? Errc::closed : Errc::io, "recvmmsg", error};
}

bool UdpCanBus::take(std::size_t i, msg::CanFrame& out) noexcept {
  Batch& b = *batch_;
  msghdr& head = b.heads[i].msg_hdr;
  Time stamp = b.read_at;
  for (cmsghdr* c = CMSG_FIRSTHDR(&head); c != nullptr; c = CMSG_NXTHDR(&head, c)) {
    if (c->cmsg_level != SOL_SOCKET) continue;
    if (c->cmsg_type == SO_RXQ_OVFL) {
      std::uint32_t seen = 0;
      std::memcpy(&seen, CMSG_DATA(c), sizeof seen);
      counters_.rx_lost(seen - overflow_);
      overflow_ = seen;
    } else if (c->cmsg_type == SO_TIMESTAMPNS) {
      timespec wall{};
      std::memcpy(&wall, CMSG_DATA(c), sizeof wall);
      stamp = b.realtime.convert(ns_of(wall));
    }
  }
  const bool own = b.from[i].sin_port == own_port_ && b.from[i].sin_addr.s_addr == own_address_;
  if (own && !spec_.receive_own) return false;
  const std::size_t size = b.heads[i].msg_len;
  if (!wire::dronecan_udp_decode(std::span(b.packets[i]).first(size), out) || (out.fd() && spec_.data_bit_rate == 0)) {
    counters_.malformed();
    return false;
  }
  out.stamp = stamp;
  if (!passes(filters_, out)) return false;
  counters_.received(out);
  return true;
}

Status UdpCanBus::send(const msg::CanFrame& frame, Time deadline) noexcept {
  std::array<std::uint8_t, wire::kDronecanUdpMax> packet{};
  const std::size_t size = wire::dronecan_udp_encode(frame, packet);
  if (size == 0) return Error{Errc::bad_argument, "frame"};
  if (const Status may = may_leave(frame, deadline); !may) return may;
  // ECONNREFUSED would be an answer to an earlier packet.
  ssize_t n = ::send(out_, packet.data(), size, MSG_DONTWAIT);
  if (n < 0 && errno == ECONNREFUSED) n = ::send(out_, packet.data(), size, MSG_DONTWAIT);
  if (n > 0) {
    counters_.sent(frame);
    if (counters_.state() == CanState::stopped) counters_.set_state(CanState::active);
    return {};
  }
  const int error = errno;
  if (error == EAGAIN || error == ENOBUFS || error == EINTR) return lost(Errc::timeout, "no room", error);
  // The interface is down, or was replaced by another of the same name: the membership is lost.
  counters_.set_state(CanState::stopped);
  if (const Time now = os_.now(); now >= rejoin_at_) {
    rejoin_at_ = now + 1s;
    static_cast<void>(join());  // or with a later frame
  }
  return lost(Errc::closed, "interface", error);
}

}  // namespace sinew::hal
