#pragma once
// Places on the ground.
#include "math/linear.hpp"

namespace sinew::motion {

struct Vec2 {
  double x = 0, y = 0;
  friend constexpr Vec2 operator+(const Vec2& a, const Vec2& b) { return {a.x + b.x, a.y + b.y}; }
  friend constexpr Vec2 operator-(const Vec2& a, const Vec2& b) { return {a.x - b.x, a.y - b.y}; }
  friend constexpr Vec2 operator*(double s, const Vec2& a) { return {s * a.x, s * a.y}; }
};
inline double norm(const Vec2& a) { return math::hypot(a.x, a.y); }
inline Vec2 turned(const Vec2& a, double yaw_rad) {
  const math::SinCos t = math::sincos(yaw_rad);
  return {t.cos * a.x - t.sin * a.y, t.sin * a.x + t.cos * a.y};
}

/// A frame on the ground in another one: `at_m` is its origin there, yaw counter-clockwise.
struct Planar {
  Vec2 at_m;
  double yaw_rad = 0;

  Vec2 of(const Vec2& p) const { return at_m + turned(p, yaw_rad); }
  Planar inverse() const { return {turned({-at_m.x, -at_m.y}, -yaw_rad), -yaw_rad}; }
  friend Planar operator*(const Planar& a, const Planar& b) { return {a.of(b.at_m), a.yaw_rad + b.yaw_rad}; }
};

}  // namespace sinew::motion
