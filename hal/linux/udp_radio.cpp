#include "hal/linux/udp_radio.hpp"

#include <ifaddrs.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "hal/linux/open_error.hpp"

namespace sinew::hal {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kRadioBatch = 16;
constexpr Duration kLookEvery = 1s;
constexpr Duration kOwnFor = 10s;     // after an address is gone
constexpr Duration kFullPause = 5ms;  // without room for more, what comes meanwhile waits in the socket or is lost

sockaddr_in in_kernels_words(const UdpAddress& address) noexcept {
  sockaddr_in out{};
  out.sin_family = AF_INET;
  out.sin_port = htons(address.port);
  out.sin_addr.s_addr = htonl(address.ipv4);
  return out;
}

template <class T>
Status set_option(int socket, int level, int name, const T& value, const char* where) noexcept {
  if (setsockopt(socket, level, name, &value, sizeof value) == 0) return {};
  return Error{Errc::io, where, errno};
}

int udp_socket() noexcept { return socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0); }

std::string words_against(const RadioSpec& spec) {
  if (spec.listens)
    return !spec.peers.empty() ? "a radio that listens has no peers" : spec.port == 0 ? "port is from 1 to 65535" : "";
  if (spec.peers.empty()) {
    if (!spec.group.is_multicast() || spec.group.port == 0)
      return to_text(spec.group) + " is no group: an address from 224.0.0.0 to 239.255.255.255, and a port";
    if (spec.ttl < 1 || spec.ttl > 255) return "ttl is from 1 to 255";
    if (spec.interface.size() >= IFNAMSIZ) return "'" + spec.interface + "' is longer than an interface's name";
    return {};
  }
  for (const UdpAddress& peer : spec.peers)
    if (peer.is_multicast() || peer.ipv4 == 0 || peer.port == 0) return to_text(peer) + " is no peer's address";
  return spec.port == 0 ? "port is from 1 to 65535" : "";
}

/// What the netlink socket has to say is that something changed.
bool drain(int socket) noexcept {
  std::array<char, 4096> message;
  bool any = false;
  while (recv(socket, message.data(), message.size(), MSG_DONTWAIT) > 0 || errno == ENOBUFS) any = true;
  return any;
}

int network_socket() noexcept {
  const int fd = socket(AF_NETLINK, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, NETLINK_ROUTE);
  sockaddr_nl all{};
  all.nl_family = AF_NETLINK;
  all.nl_groups = RTMGRP_LINK | RTMGRP_IPV4_IFADDR | RTMGRP_IPV4_ROUTE;
  if (fd < 0 || bind(fd, reinterpret_cast<const sockaddr*>(&all), sizeof all) == 0) return fd;
  close(fd);
  return -1;
}

}  // namespace

UdpRadio::UdpRadio(const RadioSpec& spec, Os& os)
    : spec_(spec), os_(os), batch_(os, kRadioBatch, msg::kMaxDatagramBytes) {
  if (has_group()) to_.push_back(in_kernels_words(spec.group));
  for (const UdpAddress& peer : spec.peers) to_.push_back(in_kernels_words(peer));
}

Result<std::unique_ptr<Radio>> UdpRadio::open(const RadioSpec& spec, Os& os, std::string& why) {
  why = words_against(spec);
  if (!why.empty()) return Error{Errc::bad_argument, "radio"};
  std::unique_ptr<UdpRadio> radio(new UdpRadio(spec, os));
  const Status opened = radio->has_group() ? radio->open_group() : radio->open_port();
  if (!opened) {
    const auto error = static_cast<int>(opened.error().detail);
    why = radio->titled(std::string(opened.error().where) + ": " + errno_text(error));
    if (error == EADDRINUSE) {
      why = radio->titled(spec.peers.empty() ? "another program has this port for itself"
                                             : "another program has this port; radios of one machine need a port each");
      return Error{Errc::busy, opened.error().where, error};
    }
    return Error{error == EACCES || error == EPERM ? Errc::denied : Errc::io, opened.error().where, error};
  }
  radio->network_ = network_socket();
  radio->look_at_network();
  ThreadOptions options;
  options.name = "radio", options.stack_bytes = std::size_t{128} * 1024;
  auto thread = os.start_thread(options, [r = radio.get()] { r->run(); });
  if (!thread) {
    why = radio->titled("its thread does not start");
    return thread.error();
  }
  radio->thread_ = std::move(*thread);
  return std::unique_ptr<Radio>(std::move(radio));
}

UdpRadio::~UdpRadio() {
  if (thread_) {
    const std::uint64_t one = 1;
    while (write(stop_, &one, sizeof one) < 0 && errno == EINTR) {
    }
    thread_->join();
  }
  if (out_ >= 0 && out_ != in_) close(out_);
  for (const int fd : {in_, network_, stop_})
    if (fd >= 0) close(fd);
}

Status UdpRadio::open_group() {
  const auto failed = [](const char* where) -> Status { return Error{Errc::io, where, errno}; };
  const int on = 1, off = 0, least = 1;
  in_ = udp_socket(), out_ = udp_socket(), stop_ = eventfd(0, EFD_CLOEXEC);
  if (in_ < 0 || out_ < 0 || stop_ < 0) return failed("socket");
  if (auto ok = UdpBatch::prepare(in_, kSocketBytes / 2); !ok) return ok;
  if (auto ok = set_option(in_, SOL_SOCKET, SO_REUSEADDR, on, "SO_REUSEADDR"); !ok) return ok;
  if (auto ok = set_option(in_, IPPROTO_IP, IP_MULTICAST_ALL, off, "IP_MULTICAST_ALL"); !ok) return ok;
  // Bound to the group itself, so that the port is open for nothing else.
  if (bind(in_, reinterpret_cast<const sockaddr*>(to_.data()), sizeof to_[0]) != 0) return failed("bind");
  if (auto ok = set_option(out_, IPPROTO_IP, IP_MULTICAST_TTL, spec_.ttl, "IP_MULTICAST_TTL"); !ok) return ok;
  if (auto ok = set_option(out_, IPPROTO_IP, IP_MULTICAST_LOOP, on, "IP_MULTICAST_LOOP"); !ok) return ok;
  if (auto ok = set_option(out_, SOL_SOCKET, SO_RCVBUF, least, "SO_RCVBUF"); !ok) return ok;  // nobody reads there
  sockaddr_in own{};
  own.sin_family = AF_INET;
  socklen_t size = sizeof own;
  if (bind(out_, reinterpret_cast<const sockaddr*>(&own), size) != 0) return failed("bind");
  if (getsockname(out_, reinterpret_cast<sockaddr*>(&own), &size) != 0) return failed("getsockname");
  own_port_ = ntohs(own.sin_port);
  return {};
}

Status UdpRadio::open_port() {
  const auto failed = [](const char* where) -> Status { return Error{Errc::io, where, errno}; };
  in_ = out_ = udp_socket(), stop_ = eventfd(0, EFD_CLOEXEC);
  if (in_ < 0 || stop_ < 0) return failed("socket");
  if (auto ok = UdpBatch::prepare(in_, kSocketBytes / 2); !ok) return ok;
  const int on = 1;
  if (auto ok = set_option(in_, SOL_SOCKET, SO_BROADCAST, on, "SO_BROADCAST"); !ok) return ok;
  if (spec_.listens)
    if (auto ok = set_option(in_, SOL_SOCKET, SO_REUSEADDR, on, "SO_REUSEADDR"); !ok) return ok;
  const sockaddr_in own = in_kernels_words({INADDR_ANY, spec_.port});
  if (bind(in_, reinterpret_cast<const sockaddr*>(&own), sizeof own) != 0) return failed("bind");
  own_port_ = spec_.port;
  return {};
}

// ---- the robot's threads

Result<bool> UdpRadio::read(msg::Datagram& out) noexcept {
  if (ring_.size() == 0) return false;
  out = ring_.at(0);
  ring_.pop();
  return true;
}

Status UdpRadio::not_sent(Errc code, const char* where, int error) noexcept {
  tx_lost_.add();
  return Error{code, where, error};
}

Status UdpRadio::send(std::span<const std::uint8_t> bytes) noexcept {
  if (bytes.empty() || bytes.size() > msg::kMaxDatagramBytes) return Error{Errc::bad_argument, "a datagram's size"};
  if (!online_.load(std::memory_order_relaxed)) return not_sent(Errc::closed, "no network", 0);
  if (spec_.listens) return Error{Errc::not_supported, "a radio that listens sends to addresses only"};
  return send_to(to_, bytes);
}

Status UdpRadio::send_to(const UdpAddress& to, std::span<const std::uint8_t> bytes) noexcept {
  if (bytes.empty() || bytes.size() > msg::kMaxDatagramBytes) return Error{Errc::bad_argument, "a datagram's size"};
  if (!online_.load(std::memory_order_relaxed)) return not_sent(Errc::closed, "no network", 0);
  const sockaddr_in address = in_kernels_words(to);
  return send_to({&address, 1}, bytes);
}

Status UdpRadio::send_to(std::span<const sockaddr_in> all, std::span<const std::uint8_t> bytes) noexcept {
  Status result;
  int worst = 0;
  for (const sockaddr_in& to : all) {
    const ssize_t n = sendto(out_, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
                             reinterpret_cast<const sockaddr*>(&to), sizeof to);
    if (n >= 0) {
      sent_.add(), sent_bytes_.add(static_cast<std::uint32_t>(bytes.size()));
      continue;
    }
    const int error = errno;
    const bool full = error == EAGAIN || error == ENOBUFS || error == ENOMEM || error == EINTR;
    result = not_sent(full ? Errc::busy : Errc::closed, "sendto", error);
    if (!full) worst = error;
  }
  send_error_.store(worst, std::memory_order_relaxed);
  return result;
}

RadioStats UdpRadio::stats() const noexcept {
  RadioStats out;
  out.received = received_.value(), out.received_bytes = received_bytes_.value();
  out.sent = sent_.value(), out.sent_bytes = sent_bytes_.value();
  out.rx_lost = rx_lost_.value(), out.rx_other = rx_other_.value(), out.tx_lost = tx_lost_.value();
  return out;
}

std::string UdpRadio::titled(const std::string& what) const {
  return (has_group() ? "group " + to_text(spec_.group) : "UDP port " + std::to_string(spec_.port)) + ": " + what;
}

std::string UdpRadio::trouble() const {
  std::string text = network_trouble_.get();
  if (const int error = send_error_.load(std::memory_order_relaxed); text.empty() && error != 0)
    text = titled("sending fails: " + errno_text(error));
  if (crowded_.load(std::memory_order_relaxed))
    text += (text.empty() ? "" : "\n") + titled("more comes in than is read; the rest is lost");
  return text;
}

// ---- its own thread

void UdpRadio::run() noexcept {
  Time look = os_.now() + kLookEvery;
  for (;;) {
    const bool full = ring_.full();
    const Duration rest = std::clamp(look - os_.now(), Duration(0), full ? kFullPause : kLookEvery);
    std::array<pollfd, 3> fds{{{stop_, POLLIN, 0}, {network_, POLLIN, 0}, {full ? -1 : in_, POLLIN, 0}}};
    if (poll(fds.data(), fds.size(), static_cast<int>((rest + 999us) / 1ms)) < 0) fds[0].revents = fds[2].revents = 0;
    if (fds[0].revents != 0) return;
    const bool due = os_.now() >= look;
    // First the network: by its addresses own datagrams are known.
    if ((network_ >= 0 && drain(network_)) || due) look_at_network();
    if (due) look_at_losses(), look = os_.now() + kLookEvery;
    if (fds[2].revents != 0) receive();
  }
}

void UdpRadio::receive() noexcept {
  const auto count = batch_.fill(in_, ring_.room());
  if (!count) return;  // an error that the kernel tells once
  bool any = false;
  for (std::size_t i = 0; i < *count; ++i) {
    const UdpPacket& packet = batch_[i];
    if (packet.lost != 0) rx_lost_.add(packet.lost), lost_ += packet.lost;
    if (is_own(packet)) continue;
    if (packet.cut || packet.bytes.empty()) {
      rx_other_.add();
      continue;
    }
    incoming_.stamp = packet.stamp;
    incoming_.sender = packet.ipv4, incoming_.port = packet.port;
    incoming_.lost = std::exchange(lost_, 0);
    // The bytes behind the datagram's are 0: equal datagrams are equal messages.
    const auto size = static_cast<std::uint32_t>(packet.bytes.size());
    std::copy(packet.bytes.begin(), packet.bytes.end(), incoming_.data.begin());
    if (size < incoming_.size) std::fill(&incoming_.data[size], &incoming_.data[size] + (incoming_.size - size), 0);
    incoming_.size = size;
    static_cast<void>(ring_.push(incoming_));  // fill() read no more than there is room for
    received_.add(), received_bytes_.add(size);
    any = true;
  }
  if (any) wake_.ring();
}

bool UdpRadio::is_own(const UdpPacket& packet) const noexcept {
  return packet.port == own_port_ &&
         std::any_of(own_.begin(), own_.end(), [&](const OwnAddress& own) { return own.ipv4 == packet.ipv4; });
}

void UdpRadio::note_own(const std::vector<Link>& links) {
  const Time now = os_.now();
  for (const Link& link : links)
    for (const std::uint32_t ipv4 : link.ipv4s) {
      const auto it = std::find_if(own_.begin(), own_.end(), [&](const OwnAddress& own) { return own.ipv4 == ipv4; });
      if (it == own_.end())
        own_.push_back({ipv4, now});
      else
        it->last_seen = now;
    }
  std::erase_if(own_, [&](const OwnAddress& own) { return now - own.last_seen > kOwnFor; });
}

void UdpRadio::look_at_losses() noexcept {
  const std::uint64_t lost = rx_lost_.value();
  crowded_.store(lost != lost_before_, std::memory_order_relaxed);
  lost_before_ = lost;
}

std::vector<UdpRadio::Link> UdpRadio::links() {
  std::vector<Link> all;
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return all;
  for (const ifaddrs* i = list; i != nullptr; i = i->ifa_next) {
    const std::string_view label = i->ifa_name;
    const std::string name(label.substr(0, label.find(':')));  // of an address's label, "eth0:1"
    auto link = std::find_if(all.begin(), all.end(), [&](const Link& l) { return l.name == name; });
    if (link == all.end()) link = all.insert(all.end(), {name, static_cast<int>(if_nametoindex(name.c_str())), 0, {}});
    link->flags = i->ifa_flags;
    if (i->ifa_addr == nullptr || i->ifa_addr->sa_family != AF_INET) continue;
    sockaddr_in address{};
    std::memcpy(&address, i->ifa_addr, sizeof address);
    link->ipv4s.push_back(ntohl(address.sin_addr.s_addr));
  }
  freeifaddrs(list);
  return all;
}

/// The address that the kernel would send to the group from; 0: there is no route.
std::uint32_t UdpRadio::source_by_route() const noexcept {
  const int probe = udp_socket();
  sockaddr_in own{};
  socklen_t size = sizeof own;
  const bool found = probe >= 0 && connect(probe, reinterpret_cast<const sockaddr*>(to_.data()), sizeof to_[0]) == 0 &&
                     getsockname(probe, reinterpret_cast<sockaddr*>(&own), &size) == 0;
  if (probe >= 0) close(probe);
  return found ? ntohl(own.sin_addr.s_addr) : 0;
}

const UdpRadio::Link* UdpRadio::choose(const std::vector<Link>& links, std::string& why) const {
  const auto find = [&](const auto& is) -> const Link* {
    const auto it = std::find_if(links.begin(), links.end(), is);
    return it == links.end() ? nullptr : &*it;
  };
  const auto carries = [](const Link& l) {
    return (l.flags & IFF_UP) != 0 && (l.flags & IFF_RUNNING) != 0 && !l.ipv4s.empty();
  };
  if (!spec_.interface.empty()) {
    const std::string name = "interface '" + spec_.interface + "'";
    const Link* link = find([&](const Link& l) { return l.name == spec_.interface; });
    if (!link)
      why = "there is no " + name + " ('ip link' lists them)";
    else if ((link->flags & IFF_UP) == 0)
      why = name + " is down";
    else if ((link->flags & IFF_RUNNING) == 0)
      why = name + " has no link (cable, access point?)";
    else if (link->ipv4s.empty())
      why = name + " has no IPv4 address";
    return why.empty() ? link : nullptr;
  }
  if (const std::uint32_t source = source_by_route(); source != 0)
    if (const Link* link = find([&](const Link& l) {
          return carries(l) && std::find(l.ipv4s.begin(), l.ipv4s.end(), source) != l.ipv4s.end();
        }))
      return link;
  if (const Link* link = find(
          [&](const Link& l) { return carries(l) && (l.flags & IFF_MULTICAST) != 0 && (l.flags & IFF_LOOPBACK) == 0; }))
    return link;
  why = "no network: only robots of this machine are heard";
  if (const Link* link = find([&](const Link& l) { return carries(l) && (l.flags & IFF_LOOPBACK) != 0; })) return link;
  why = "no network";
  return nullptr;
}

void UdpRadio::look_at_network() noexcept {
  const std::vector<Link> all = links();
  note_own(all);
  if (!has_group()) {
    online_.store(true, std::memory_order_relaxed);  // the kernel knows for each peer whether there is a way
    return;
  }
  std::string why;
  const Link* link = choose(all, why);
  if (!link) leave();
  if (link && !join(link->index, link->ipv4s[0]))
    why = "'" + link->name + "' cannot join: " + errno_text(errno), leave();
  network_trouble_.set(why.empty() ? why : titled(why));
  online_.store(joined_ != 0, std::memory_order_relaxed);
}

bool UdpRadio::join(int index, std::uint32_t source) noexcept {
  if (index == joined_ && source == source_) return true;
  ip_mreqn where{};
  where.imr_multiaddr = to_[0].sin_addr;
  where.imr_ifindex = index;
  if (index != joined_) {
    leave();
    if (setsockopt(in_, IPPROTO_IP, IP_ADD_MEMBERSHIP, &where, sizeof where) != 0 && errno != EADDRINUSE) return false;
    joined_ = index;
  }
  // The source is named: the kernel takes an address of another interface, or none, where it finds the scope too small.
  where.imr_address.s_addr = htonl(source);
  source_ = source;
  return setsockopt(out_, IPPROTO_IP, IP_MULTICAST_IF, &where, sizeof where) == 0;
}

/// Also of an interface that is gone: the kernel counts memberships of a socket, and allows few.
void UdpRadio::leave() noexcept {
  if (joined_ == 0) return;
  ip_mreqn where{};
  where.imr_multiaddr = to_[0].sin_addr;
  where.imr_ifindex = joined_;
  static_cast<void>(setsockopt(in_, IPPROTO_IP, IP_DROP_MEMBERSHIP, &where, sizeof where));
  joined_ = 0;
}

}  // namespace sinew::hal
