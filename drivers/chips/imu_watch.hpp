#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "hal/clock.hpp"

namespace sinew::drivers {

/// Tells a bus that is held low or high, and a chip that repeats itself, from one that measures.
/// Thread:  owner.   RT: yes.
class ImuWatch {
 public:
  explicit ImuWatch(hal::Duration stuck_after) : stuck_after_(stuck_after) {}
  /// All bytes 0x00 or all 0xFF: six axes of a real chip never are.
  static bool is_dead(std::span<const std::uint8_t> bytes) noexcept {
    const auto all = [&](std::uint8_t v) {
      return std::all_of(bytes.begin(), bytes.end(), [v](auto b) { return b == v; });
    };
    return all(0x00) || all(0xFF);
  }
  /// A sample read at `now`. True: it has been the same for too long; noise alone moves the lowest bits of a chip.
  bool is_stuck(const std::array<std::int16_t, 6>& raw, hal::Time now) noexcept {
    if (!any_ || raw != last_) {
      last_ = raw;
      since_ = now;
      any_ = true;
    }
    return stuck_after_.count() > 0 && now - since_ >= stuck_after_;
  }
  void restart() noexcept { any_ = false; }

 private:
  hal::Duration stuck_after_;
  std::array<std::int16_t, 6> last_{};
  hal::Time since_;
  bool any_ = false;
};

}  // namespace sinew::drivers
