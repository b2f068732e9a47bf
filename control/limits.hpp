#pragma once
#include "math/linear.hpp"
#include "msg/time.hpp"

namespace sinew::control {

constexpr double square(double x) { return x * x; }
constexpr double clamp(double x, double low, double high) { return x < low ? low : x > high ? high : x; }

/// The horizontal part of `v`, shortened to at most `limit`; z as it is.
inline math::Vec3 limit_horizontal(const math::Vec3& v, double limit) {
  const double n = math::sqrt(v.x * v.x + v.y * v.y);
  if (n <= limit) return v;
  return {v.x * (limit / n), v.y * (limit / n), v.z};
}

/// Length of a step for integrals and derivatives: a long pause counts only in part.
inline double step_seconds(msg::Duration dt) { return clamp(msg::seconds(dt), 1e-5, 0.05); }

}  // namespace sinew::control
