#pragma once
// Places of a robot on the field, and how they follow its odometry.
// Frames:  "field" and "robot" of msg/soccer.hpp.
// Thread:  any.   RT: yes.
#include "math/elementary.hpp"
#include "soccer/field.hpp"

namespace sinew::soccer {

/// A pose on the ground: of a robot on the field, of a robot in its odometry's frame, or of one such frame in another.
struct FieldAt {
  double x_m = 0, y_m = 0, heading_rad = 0;

  /// A point in the frame of this pose, in the frame that the pose is in.
  FieldPoint out(double x_m_, double y_m_) const {
    const math::SinCos t = math::sincos(heading_rad);
    return {x_m + t.cos * x_m_ - t.sin * y_m_, y_m + t.sin * x_m_ + t.cos * y_m_};
  }
  /// The other way round.
  FieldPoint in(double x_m_, double y_m_) const {
    const math::SinCos t = math::sincos(heading_rad);
    const double dx = x_m_ - x_m, dy = y_m_ - y_m;
    return {t.cos * dx + t.sin * dy, t.cos * dy - t.sin * dx};
  }
  /// A pose in the frame of this pose, in the frame that the pose is in.
  FieldAt then(const FieldAt& step) const {
    const FieldPoint p = out(step.x_m, step.y_m);
    return {p.x_m, p.y_m, math::wrap_pi(heading_rad + step.heading_rad)};
  }
  /// The pose `to`, in the same frame as this one, seen from this one: then(way_to(to)) is `to`.
  FieldAt way_to(const FieldAt& to) const {
    const FieldPoint p = in(to.x_m, to.y_m);
    return {p.x_m, p.y_m, math::wrap_pi(to.heading_rad - heading_rad)};
  }
  /// The pose on the other half of the field that looks the same.
  FieldAt mirrored() const { return {-x_m, -y_m, math::wrap_pi(heading_rad + math::kPi)}; }
};

inline double distance_m(const FieldAt& a, const FieldAt& b) { return math::hypot(a.x_m - b.x_m, a.y_m - b.y_m); }
inline double turn_between_rad(const FieldAt& a, const FieldAt& b) {
  return math::fabs(math::wrap_pi(a.heading_rad - b.heading_rad));
}

}  // namespace sinew::soccer
