#include "hal/linux/can/udp_can.hpp"

#include <arpa/inet.h>
#include <net/if.h>
#include <sys/socket.h>
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

UdpCanBus::UdpCanBus(const CanSpec& spec, Os& os, std::shared_ptr<FdWatch> watch)
    : CanPort(spec, os, std::move(watch)), batch_(os, kUdpBatch, wire::kDronecanUdpMax) {}

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
  const int on = 1, off = 0;
  if (setsockopt(in_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) != 0) return failed("SO_REUSEADDR");
  // Bound to the group itself: this keeps frames of other buses, which use the same port, out.
  if (bind(in_, reinterpret_cast<const sockaddr*>(&group_), sizeof group_) != 0) return failed("bind");
  if (setsockopt(in_, IPPROTO_IP, IP_MULTICAST_ALL, &off, sizeof off) != 0) return failed("IP_MULTICAST_ALL");
  if (const Status prepared = UdpBatch::prepare(in_, kUdpReceiveBytes); !prepared) return prepared;
  if (const Status joined = join(); !joined) return joined;
  if (connect(out_, reinterpret_cast<const sockaddr*>(&group_), sizeof group_) != 0) return failed("connect");
  sockaddr_in own{};
  socklen_t size = sizeof own;
  if (getsockname(out_, reinterpret_cast<sockaddr*>(&own), &size) != 0) return failed("getsockname");
  own_port_ = ntohs(own.sin_port), own_ipv4_ = ntohl(own.sin_addr.s_addr);
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
    if (next_ == count_) {
      const auto filled = fill();
      if (!filled || !*filled) return filled;
    }
    if (take(batch_[next_++], out)) return true;
  }
}

Result<bool> UdpCanBus::fill() noexcept {
  next_ = count_ = 0;
  const auto filled = batch_.fill(in_, batch_.capacity());
  if (!filled) return filled.error();
  count_ = *filled;
  return count_ > 0;
}

bool UdpCanBus::take(const UdpPacket& packet, msg::CanFrame& out) noexcept {
  if (packet.lost != 0) counters_.rx_lost(packet.lost);
  const bool own = packet.port == own_port_ && packet.ipv4 == own_ipv4_;
  if (own && !spec_.receive_own) return false;
  if (packet.cut || !wire::dronecan_udp_decode(packet.bytes, out) || (out.fd() && spec_.data_bit_rate == 0)) {
    counters_.malformed();
    return false;
  }
  out.stamp = packet.stamp;
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
