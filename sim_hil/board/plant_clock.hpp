#pragma once
#include <algorithm>
#include <cstdint>
#include <cstdlib>

#include "hal/clock.hpp"
#include "hal/wide.hpp"

namespace sinew::sim_hil {

/// Plant time on the runtime's clock. It moves slowly to a better estimate: the distance of two stamps never changes by
/// more than `kSlew` of it, and no stamp goes backwards.
/// Thread:  receiver: set(), map(). Any: the others.
/// RT:      yes.
class PlantClock {
 public:
  static constexpr double kSlew = 500e-6;  // 0.5 us of a 1 ms period; above what clocks drift apart

  /// A new connection: jumps to this offset at once.
  void set(hal::Duration offset) noexcept {
    target_ns_.store(offset.count(), std::memory_order_relaxed);
    offset_ns_.store(offset.count(), std::memory_order_relaxed);
    newest_ = {};
  }
  /// The offset to move to.
  void steer(hal::Duration offset) noexcept { target_ns_.store(offset.count(), std::memory_order_relaxed); }

  hal::Time map(hal::Time plant) noexcept {
    const std::int64_t now_ns = offset_ns_.load(std::memory_order_relaxed);
    if (plant > newest_) {
      const auto most = static_cast<std::int64_t>(kSlew * static_cast<double>((plant - newest_).count()));
      const std::int64_t wanted = target_ns_.load(std::memory_order_relaxed) - now_ns;
      offset_ns_.store(now_ns + std::clamp(wanted, -most, most), std::memory_order_relaxed);
      newest_ = plant;
    }
    return plant + offset();
  }
  /// Runtime clock minus plant time, as used now.
  hal::Duration offset() const noexcept { return hal::Duration{offset_ns_.load(std::memory_order_relaxed)}; }
  /// How far the offset still has to move.
  hal::Duration lag() const noexcept {
    return hal::Duration{std::abs(target_ns_.load(std::memory_order_relaxed) - offset().count())};
  }

 private:
  // Independent values: no thread concludes anything from one about the other.
  hal::Wide<std::int64_t> target_ns_, offset_ns_;
  hal::Time newest_{};
};

}  // namespace sinew::sim_hil
