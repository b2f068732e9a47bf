#pragma once
#include <limits>

#include "hal/wide.hpp"
#include "msg/time.hpp"

namespace sinew::hal {

using msg::Duration;
using msg::Time;

inline constexpr Time kNever{std::numeric_limits<std::int64_t>::max()};

/// The present time. The executor decides when the next step begins.
/// Thread:  any.   RT: yes.
class Clock {
 public:
  virtual ~Clock() = default;
  virtual Time now() const noexcept = 0;
};

/// A clock that stands still until its owner moves it: virtual time.
/// Thread:  owner writes; any reads. Moving the clock does not make earlier writes visible.
class ManualClock final : public Clock {
 public:
  Time now() const noexcept override { return {now_ns_.load()}; }
  void set(Time t) noexcept { now_ns_.store(t.ns); }

 private:
  Wide<std::int64_t> now_ns_;  // relaxed: no thread waits for it
};

}  // namespace sinew::hal
