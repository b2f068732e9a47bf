#pragma once
#include <cstdint>
#include <limits>
#include <type_traits>

namespace sinew::math {

/// The one way from floating point to an integer: towards zero, saturating at the integer's range, NaN becomes 0. (A
/// plain cast outside the range is undefined, and x86, ARM and MIPS really differ.) To round: to_integer<I>(round(x)).
template <class I>
constexpr I to_integer(double x) {
  static_assert(std::is_integral_v<I> && !std::is_same_v<I, bool>);
  using Limits = std::numeric_limits<I>;
  // max() + 1 is a power of two and so exact as a double, where max() itself may not be.
  constexpr double above = 2.0 * static_cast<double>(Limits::max() / 2 + 1);
  constexpr double lowest = static_cast<double>(Limits::min());
  if (x >= above) return Limits::max();
  if (x <= lowest) return Limits::min();
  return x == x ? static_cast<I>(x) : I{0};
}

}  // namespace sinew::math
