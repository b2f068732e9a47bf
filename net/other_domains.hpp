#pragma once
#include <poll.h>
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hal/clock.hpp"

namespace sinew::net {

/// Who sent a datagram of DDS's wire protocol.
struct RtpsSender {
  std::array<std::uint8_t, 12> prefix{};  // of its participant's GUID
  std::uint16_t vendor = 0;
};
/// Nothing: it is no message of RTPS 2. Source: DDSI-RTPS 2.3, section 9.4.4.
std::optional<RtpsSender> rtps_sender(std::span<const std::uint8_t> datagram);
/// "Cyclone DDS", "Fast DDS", "vendor 01.7f".
std::string vendor_name(std::uint16_t vendor);

/// Listens to the announcements of participants in other domains than ours, which use other ports: only where they
/// announce themselves by multicast, and only the first kListened domains. Nothing is answered.
/// Thread:  owner.
class OtherDomains {
 public:
  OtherDomains(std::uint32_t own, const std::vector<std::string>& addresses);
  ~OtherDomains();
  OtherDomains(const OtherDomains&) = delete;
  OtherDomains& operator=(const OtherDomains&) = delete;
  void add_fds(std::vector<pollfd>& fds) const;
  void look(hal::Time now);

  struct Heard {
    std::uint32_t domain = 0;
    std::string address{}, vendor{};
  };
  /// Those of the last kRemembered.
  std::vector<Heard> heard(hal::Time now) const;

  static constexpr std::uint32_t kListened = 20;
  static constexpr hal::Duration kRemembered = std::chrono::seconds(70);  // two announcements of most implementations

 private:
  struct Entry {
    Heard who;
    hal::Time at;
  };
  struct Line {
    int fd;
    std::uint32_t domain;
  };
  std::vector<Line> lines_;
  std::map<std::array<std::uint8_t, 12>, Entry> heard_;
};

}  // namespace sinew::net
