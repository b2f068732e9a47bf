#pragma once
#include "math/linear.hpp"

namespace sinew::control {

constexpr double clamp(double x, double low, double high) { return x < low ? low : x > high ? high : x; }

/// The horizontal part of `v`, shortened to at most `limit`; z as it is.
inline math::Vec3 limit_horizontal(const math::Vec3& v, double limit) {
  const double n = math::sqrt(v.x * v.x + v.y * v.y);
  if (n <= limit) return v;
  return {v.x * (limit / n), v.y * (limit / n), v.z};
}

}  // namespace sinew::control
