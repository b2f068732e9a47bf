#pragma once
#include <chrono>
#include <compare>
#include <cstdint>

namespace sinew::msg {

using Duration = std::chrono::nanoseconds;

/// A point on the robot's monotonic clock; wall time never mixes with it.
/// Units:   nanoseconds since an origin that is the same for the whole run (boot of the board, or start of virtual
///          time).
struct Time {
  std::int64_t ns = 0;

  friend constexpr auto operator<=>(const Time&, const Time&) = default;
  friend constexpr Time operator+(Time t, Duration d) { return {t.ns + d.count()}; }
  friend constexpr Time operator-(Time t, Duration d) { return {t.ns - d.count()}; }
  friend constexpr Duration operator-(Time a, Time b) { return Duration{a.ns - b.ns}; }
};

constexpr double seconds(Duration d) { return static_cast<double>(d.count()) * 1e-9; }
constexpr double seconds(Time t) { return static_cast<double>(t.ns) * 1e-9; }

}  // namespace sinew::msg
