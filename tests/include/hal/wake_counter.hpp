#pragma once
// A Wake that tests hand to a device.
#include <cstdint>

#include "hal/device.hpp"
#include "hal/platform.hpp"

namespace sinew::hal {

/// Counts wake-ups and lets the test sleep until there was one. Thread: any.
class WakeCounter final : public Wake {
 public:
  void wake() noexcept override {
    count_.fetch_add(1, std::memory_order_release);
    system_os().wake(count_);
  }
  std::uint32_t count() const { return count_.load(std::memory_order_acquire); }
  void wait_beyond(std::uint32_t seen, Time deadline) { system_os().wait(count_, seen, deadline); }
  /// Sleeps until `done()`, which is asked again after each wake-up. False: it was not within a time that only a broken
  /// machine reaches.
  template <class Done>
  bool wait_until(Done done) {
    const Time deadline = system_os().now() + std::chrono::seconds(20);
    for (;;) {
      const std::uint32_t seen = count();
      if (done()) return true;
      if (system_os().now() > deadline) return false;
      wait_beyond(seen, system_os().now() + std::chrono::milliseconds(50));
    }
  }
  bool wait_for(std::uint32_t times) {
    return wait_until([&] { return count() >= times; });
  }

 private:
  WakeWord count_{0};
};

}  // namespace sinew::hal
