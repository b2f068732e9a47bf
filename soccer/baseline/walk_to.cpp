#include "soccer/baseline/walk_to.hpp"

#include <algorithm>
#include <array>

namespace sinew::soccer::baseline {
namespace {

constexpr std::size_t kMostRounds = 16;

/// A piece of the horizon that is not free: its middle, and half of its width.
struct Blocked {
  double middle_rad = 0, half_rad = 0;
};

bool covers(const Blocked& b, double way_rad) { return math::fabs(math::wrap_pi(way_rad - b.middle_rad)) < b.half_rad; }

}  // namespace

double way_rad(const FieldPoint& to, std::span<const Round> in_the_way, double margin_m) {
  const double wanted = bearing_rad(to), far_m = length_m(to);
  std::array<Blocked, kMostRounds> blocked;
  std::size_t n = 0;
  for (const Round& r : in_the_way) {
    const double away_m = length_m(r.at), keep_m = r.radius_m + margin_m;
    if (away_m - keep_m >= far_m || n == kMostRounds) continue;  // behind the place
    if (away_m <= keep_m) {
      // Too near: half of the horizon and, the deeper inside, up to all of it but straight away.
      const double deep = keep_m > 0 ? 1 - away_m / keep_m : 0;
      blocked[n++] = {bearing_rad(r.at), 0.5 * math::kPi * (1 + 0.9 * deep)};
    } else {
      blocked[n++] = {bearing_rad(r.at), math::asin(keep_m / away_m)};
    }
  }
  const auto free = [&](double way) {
    return std::none_of(blocked.begin(), blocked.begin() + n, [&](const Blocked& b) { return covers(b, way); });
  };
  if (free(wanted)) return wanted;
  // The free edge that is nearest to the wanted direction.
  double best = wanted, best_off = math::kInf;
  for (std::size_t i = 0; i < n; ++i)
    for (const double side : {1.0, -1.0}) {
      const double edge = blocked[i].middle_rad + side * (blocked[i].half_rad + 1e-6);
      const double off = math::fabs(math::wrap_pi(edge - wanted));
      if (off < best_off && free(edge)) best = math::wrap_pi(edge), best_off = off;
    }
  return best;
}

WalkSpeed walk_to(const FieldAt& to, std::span<const Round> in_the_way, const WalkLimits& l) {
  const double far_m = math::hypot(to.x_m, to.y_m);
  const double way = far_m > 0 ? way_rad({to.x_m, to.y_m}, in_the_way, l.margin_m) : 0;
  const bool round = far_m > 0 && math::fabs(math::wrap_pi(way - math::atan2(to.y_m, to.x_m))) > 1e-3;
  const auto turn = [&](double by_rad) { return std::clamp(l.per_s * by_rad, -l.turn_radps, l.turn_radps); };
  if (far_m > l.near_m) {
    // Turned to the way, and slower as long as it is not.
    const double ahead = std::max(0.0, math::cos(way));
    return {l.forward_mps * ahead * ahead, 0, turn(way)};
  }
  const double speed_mps = l.per_s * far_m;
  const math::SinCos t = math::sincos(way);
  WalkSpeed out{speed_mps * t.cos, speed_mps * t.sin, turn(to.heading_rad)};
  if (round) {  // goes round it at its own speed
    const double least = l.side_mps / std::max(speed_mps, 1e-9);
    if (least > 1) out.forward_mps *= least, out.left_mps *= least;
  }
  // One direction's limit slows the other one, too.
  const double most_forward = out.forward_mps < 0 ? l.back_mps : l.forward_mps;
  const double share = math::hypot(out.forward_mps / most_forward, out.left_mps / l.side_mps);
  if (share > 1) out.forward_mps /= share, out.left_mps /= share;
  return out;
}

}  // namespace sinew::soccer::baseline
