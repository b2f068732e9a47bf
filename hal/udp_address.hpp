#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace sinew::hal {

/// Where datagrams go to or come from.
struct UdpAddress {
  std::uint32_t ipv4 = 0;  // as a number: 127.0.0.1 is 0x7F000001
  std::uint16_t port = 0;

  bool is_multicast() const noexcept { return ipv4 >> 28 == 0xE; }
  friend bool operator==(const UdpAddress&, const UdpAddress&) = default;
};

/// "192.168.1.2:4580": four numbers of 0 to 255 and a port of 1 to 65535. Nothing: it is something else. Names are not
/// looked up: whoever could resolve them may not be there when a robot starts.
std::optional<UdpAddress> udp_address(std::string_view text) noexcept;
std::string to_text(const UdpAddress& address);

}  // namespace sinew::hal
