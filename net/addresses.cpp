#include "net/addresses.hpp"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>

namespace sinew::net {
namespace {

constexpr hal::Duration kLookAnyway = std::chrono::seconds(1);

int netlink_of_addresses() {
  const int fd = socket(AF_NETLINK, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, NETLINK_ROUTE);
  sockaddr_nl all{};
  all.nl_family = AF_NETLINK;
  all.nl_groups = RTMGRP_LINK | RTMGRP_IPV4_IFADDR;
  if (fd < 0 || bind(fd, reinterpret_cast<const sockaddr*>(&all), sizeof all) == 0) return fd;
  close(fd);
  return -1;
}

/// What it has to say is that something changed.
bool take_netlink(int fd) {
  std::array<char, 4096> message;
  bool any = false;
  while (recv(fd, message.data(), message.size(), MSG_DONTWAIT) > 0 || errno == ENOBUFS) any = true;
  return any;
}

/// The kernel's numbers of the interfaces of "wlan0 10.0.0.2", which it never gives again; 0: it is gone.
std::vector<unsigned> numbers_of(const std::vector<std::string>& addresses) {
  std::vector<unsigned> all;
  for (const std::string& one : addresses) all.push_back(if_nametoindex(one.substr(0, one.find(' ')).c_str()));
  return all;
}

}  // namespace

std::vector<std::string> network_addresses(const std::vector<std::string>& interfaces) {
  std::vector<std::string> all;
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return all;
  for (const ifaddrs* i = list; i != nullptr; i = i->ifa_next) {
    if (i->ifa_addr == nullptr || i->ifa_addr->sa_family != AF_INET || (i->ifa_flags & IFF_UP) == 0) continue;
    std::array<char, INET_ADDRSTRLEN> text{};
    inet_ntop(AF_INET, &reinterpret_cast<const sockaddr_in*>(i->ifa_addr)->sin_addr, text.data(), text.size());
    const std::string name = i->ifa_name, address = text.data();
    const auto named = [&](const std::string& one) { return one == name || one == address; };
    const bool ours = interfaces.empty() ? (i->ifa_flags & IFF_LOOPBACK) == 0
                                         : std::any_of(interfaces.begin(), interfaces.end(), named);
    if (ours) all.push_back(name + " " + address);
  }
  freeifaddrs(list);
  std::sort(all.begin(), all.end());
  return all;
}

AddressWatch::AddressWatch(std::vector<std::string> interfaces)
    : interfaces_(std::move(interfaces)),
      fd_(netlink_of_addresses()),
      at_start_(network_addresses(interfaces_)),
      at_start_numbers_(numbers_of(at_start_)),
      last_(at_start_),
      last_numbers_(at_start_numbers_) {}

AddressWatch::~AddressWatch() {
  if (fd_ >= 0) close(fd_);
}

bool AddressWatch::changed(hal::Time now) {
  const bool news = fd_ >= 0 && take_netlink(fd_);
  const bool settling = !is_as_at_start();
  if (!news && !settling && now < look_) return false;
  look_ = now + kLookAnyway;
  auto present = network_addresses(interfaces_);
  auto numbers = numbers_of(present);
  if (present != last_ || numbers != last_numbers_)
    last_ = std::move(present), last_numbers_ = std::move(numbers), since_ = now;
  return !is_as_at_start() && now - since_ >= kSettle;
}

}  // namespace sinew::net
