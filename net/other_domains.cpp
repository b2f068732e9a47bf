#include "net/other_domains.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace sinew::net {
namespace {

constexpr std::size_t kMostHeard = 64;  // participants; the oldest go first
constexpr int kMostDatagrams = 16;      // of a domain, at one look

/// Discovery's default group and ports. Source: DDSI-RTPS 2.3, section 9.6.2.
constexpr std::uint32_t kDiscoveryGroup = 0xEFFF0001, kPortBase = 7400, kPortsOfADomain = 250;

int discovery_socket(std::uint32_t domain, const std::vector<std::string>& addresses) {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0), on = 1, off = 0;
  sockaddr_in own{};
  own.sin_family = AF_INET;
  own.sin_port = htons(static_cast<std::uint16_t>(kPortBase + kPortsOfADomain * domain));
  own.sin_addr.s_addr = htonl(kDiscoveryGroup);
  bool joined = false;
  if (fd >= 0 && setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) == 0 &&
      setsockopt(fd, IPPROTO_IP, IP_MULTICAST_ALL, &off, sizeof off) == 0 &&
      bind(fd, reinterpret_cast<const sockaddr*>(&own), sizeof own) == 0)
    for (const std::string& one : addresses) {  // "wlan0 10.0.0.2"
      ip_mreqn where{};
      where.imr_multiaddr.s_addr = htonl(kDiscoveryGroup);
      const bool is_address = inet_pton(AF_INET, one.substr(one.find(' ') + 1).c_str(), &where.imr_address) == 1;
      joined |= is_address && setsockopt(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, &where, sizeof where) == 0;
    }
  if (joined) return fd;
  if (fd >= 0) close(fd);
  return -1;
}

}  // namespace

std::optional<RtpsSender> rtps_sender(std::span<const std::uint8_t> d) {
  constexpr std::size_t kHead = 20;
  if (d.size() < kHead || d[0] != 'R' || d[1] != 'T' || d[2] != 'P' || d[3] != 'S' || d[4] != 2) return std::nullopt;
  RtpsSender out;
  out.vendor = static_cast<std::uint16_t>(d[6] << 8 | d[7]);
  std::copy(d.begin() + 8, d.begin() + kHead, out.prefix.begin());
  return out;
}

std::string vendor_name(std::uint16_t vendor) {
  if (vendor == 0x0110) return "Cyclone DDS";
  if (vendor == 0x010F) return "Fast DDS";
  if (vendor == 0x0101) return "RTI Connext";
  if (vendor == 0x0103) return "OpenDDS";
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "vendor %02x.%02x", vendor >> 8, vendor & 0xFF);
  return text.data();
}

OtherDomains::OtherDomains(std::uint32_t own, const std::vector<std::string>& addresses) {
  for (std::uint32_t domain = 0; domain < kListened; ++domain) {
    if (domain == own) continue;
    if (const int fd = discovery_socket(domain, addresses); fd >= 0) lines_.push_back({fd, domain});
  }
}

OtherDomains::~OtherDomains() {
  for (const Line& line : lines_) close(line.fd);
}

void OtherDomains::add_fds(std::vector<pollfd>& fds) const {
  for (const Line& line : lines_) fds.push_back({line.fd, POLLIN, 0});
}

void OtherDomains::look(hal::Time now) {
  std::array<std::uint8_t, 64> head;  // the rest is not wanted
  for (const Line& line : lines_)
    for (int i = 0; i < kMostDatagrams; ++i) {
      sockaddr_in from{};
      socklen_t size = sizeof from;
      const ssize_t n =
          recvfrom(line.fd, head.data(), head.size(), MSG_DONTWAIT, reinterpret_cast<sockaddr*>(&from), &size);
      if (n < 0) break;
      const auto sender = rtps_sender({head.data(), static_cast<std::size_t>(n)});
      if (!sender) continue;
      std::array<char, INET_ADDRSTRLEN> text{};
      inet_ntop(AF_INET, &from.sin_addr, text.data(), text.size());
      heard_[sender->prefix] = {{line.domain, text.data(), vendor_name(sender->vendor)}, now};
      if (heard_.size() > kMostHeard)
        heard_.erase(std::min_element(heard_.begin(), heard_.end(),
                                      [](const auto& a, const auto& b) { return a.second.at < b.second.at; }));
    }
}

std::vector<OtherDomains::Heard> OtherDomains::heard(hal::Time now) const {
  std::vector<Heard> all;
  for (const auto& [prefix, entry] : heard_)
    if (now - entry.at <= kRemembered) all.push_back(entry.who);
  std::stable_sort(all.begin(), all.end(), [](const Heard& a, const Heard& b) { return a.domain < b.domain; });
  return all;
}

}  // namespace sinew::net
