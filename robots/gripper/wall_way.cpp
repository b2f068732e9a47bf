#include "robots/gripper/wall_way.hpp"

#include <algorithm>

#include "math/elementary.hpp"

namespace sinew::gripper {

using soccer::FieldPoint;

namespace {

constexpr double kSpare_m = 0.1;  // corners are so much outside of the margin

double distance(const FieldPoint& a, const FieldPoint& b) { return math::hypot(a.x_m - b.x_m, a.y_m - b.y_m); }

/// Of the piece of the way, 0 to 1, for which one coordinate is within low and high.
void clip(double at, double to, double low, double high, double& from, double& until) {
  if (at == to) {
    if (at <= low || at >= high) until = -1;
    return;
  }
  const double a = (low - at) / (to - at), b = (high - at) / (to - at);
  from = std::max(from, std::min(a, b));
  until = std::min(until, std::max(a, b));
}

}  // namespace

bool is_blocked(const FieldPoint& at, const FieldPoint& to, const Wall& wall, double margin_m) {
  if (!wall.stands()) return false;
  double from = 0, until = 1;
  clip(at.x_m, to.x_m, wall.x_m - margin_m, wall.x_m + margin_m, from, until);
  clip(at.y_m, to.y_m, wall.from_y_m - margin_m, wall.to_y_m + margin_m, from, until);
  return from < until;
}

FieldPoint way_round(const FieldPoint& at, const FieldPoint& to, const Wall& wall, double margin_m, WallEnd& end) {
  if (!is_blocked(at, to, wall, margin_m)) {
    end = WallEnd::none;
    return to;
  }
  const double out_m = margin_m + kSpare_m, far_side = to.x_m < wall.x_m ? -1 : 1;
  const auto corner = [&](WallEnd e, double of_side) {
    return FieldPoint{wall.x_m + of_side * out_m, e == WallEnd::from ? wall.from_y_m - out_m : wall.to_y_m + out_m};
  };
  if (end == WallEnd::none) {
    const auto length = [&](WallEnd e) {
      const FieldPoint here = corner(e, -far_side), there = corner(e, far_side);
      return distance(at, here) + distance(here, there) + distance(there, to);
    };
    end = length(WallEnd::from) <= length(WallEnd::to) ? WallEnd::from : WallEnd::to;
  }
  const FieldPoint there = corner(end, far_side);
  return is_blocked(at, there, wall, margin_m) ? corner(end, -far_side) : there;
}

}  // namespace sinew::gripper
