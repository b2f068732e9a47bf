#pragma once
// The kernel's facts about a CAN interface besides its frames, by netlink.
#include <cstddef>
#include <span>
#include <string>

#include "hal/can_bus.hpp"

namespace sinew::hal {

struct CanLink {
  int index = 0;
  bool up = false;
  bool fd = false;   // CAN FD frames fit (its MTU)
  std::string kind;  // "can": a controller; "vcan", "vxcan": none of what follows
  CanState state = CanState::active;
  std::uint32_t restart_ms = 0;  // 0: the kernel leaves a controller that is bus-off alone
  std::uint32_t bit_rate = 0, data_bit_rate = 0;
  std::uint8_t tx_errors = 0, rx_errors = 0;
};

/// Errors:  not_found when there is no interface of this name; bad_argument when it is no CAN interface; io with errno.
/// Thread:  any.   RT: no.
Result<CanLink> read_can_link(const std::string& name);

/// Brings a controller that is bus-off back on its bus. Needs CAP_NET_ADMIN. Errors: denied; busy when it is not
/// bus-off, or restarts without help; io with errno.
Status restart_can(int index);

/// Reads the answer of the kernel to a question about one interface; split off for tests. `answer` begins with its
/// nlmsghdr. Errors: bad_data, bad_argument; not_found, io when the kernel answers with an error.
Result<CanLink> parse_can_link(std::span<const std::byte> answer);

}  // namespace sinew::hal
