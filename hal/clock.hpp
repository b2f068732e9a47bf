#pragma once
#include <limits>

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
/// Thread:  owner writes; whoever reads runs on the owner's thread.
class ManualClock final : public Clock {
 public:
  Time now() const noexcept override { return now_; }
  void set(Time t) noexcept { now_ = t; }

 private:
  Time now_{};
};

}  // namespace sinew::hal
