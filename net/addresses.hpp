#pragma once
#include <string>
#include <vector>

#include "hal/clock.hpp"

namespace sinew::net {

/// The IPv4 addresses of this machine that DDS uses, "wlan0 10.0.0.2", sorted: of interfaces that are up, and only of
/// `interfaces` (names or addresses) where there are some. Loopback counts only when it is named.
std::vector<std::string> network_addresses(const std::vector<std::string>& interfaces);

/// Tells that the addresses have changed: Cyclone DDS does not follow them, so that a new process is needed. A change
/// has to last for a while, since an interface that comes gets its addresses one after the other. Thread:  owner.
class AddressWatch {
 public:
  explicit AddressWatch(std::vector<std::string> interfaces);
  ~AddressWatch();
  AddressWatch(const AddressWatch&) = delete;
  AddressWatch& operator=(const AddressWatch&) = delete;
  /// Readable when the kernel says that something changed; -1: changes are found each second only.
  int fd() const { return fd_; }
  /// True: the addresses or their interfaces are others than at the start, and have been the same for kSettle.
  bool changed(hal::Time now);
  const std::vector<std::string>& at_start() const { return at_start_; }

  static constexpr hal::Duration kSettle = std::chrono::milliseconds(300);

 private:
  bool is_as_at_start() const { return last_ == at_start_ && last_numbers_ == at_start_numbers_; }

  const std::vector<std::string> interfaces_;
  int fd_ = -1;
  std::vector<std::string> at_start_;
  std::vector<unsigned> at_start_numbers_;  // of the interfaces, one for each address
  std::vector<std::string> last_;
  std::vector<unsigned> last_numbers_;
  hal::Time since_{};  // last_ is as it is
  hal::Time look_{};
};

}  // namespace sinew::net
