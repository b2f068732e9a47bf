#pragma once
#include <limits>

#include "hal/wide.hpp"
#include "msg/time.hpp"

namespace sinew::hal {

using msg::Duration;
using msg::Time;

inline constexpr Time kNever{std::numeric_limits<std::int64_t>::max()};

/// "What time is it", apart from "when does the next step fire" (that is the executor's matter).
/// Thread:  any.   RT: yes.
class Clock {
 public:
  virtual ~Clock() = default;
  virtual Time now() const noexcept = 0;
};

/// A clock that stands still until its owner moves it: virtual time.
/// Thread:  owner writes; any reads. What was written before it moved is not thereby visible.
class ManualClock final : public Clock {
 public:
  Time now() const noexcept override { return {now_ns_.load()}; }
  void set(Time t) noexcept { now_ns_.store(t.ns); }

 private:
  Wide<std::int64_t> now_ns_;  // alone: nobody waits for it
};

}  // namespace sinew::hal
