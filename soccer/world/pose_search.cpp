#include "soccer/world/pose_search.hpp"

#include <algorithm>

namespace sinew::soccer {
namespace {

using Kind = ScoredSight::Kind;
constexpr std::size_t kMostMarks = 5;
constexpr double kOutside_m = 1.1;                  // where a robot may still stand: on the carpet
constexpr double kApart_m = 0.6, kApart_rad = 0.4;  // of poses unlike each other
constexpr double kPlace_m = 0.12, kAngle = 0.12;    // what a sighting is wrong by beside its own variance
constexpr double kScatter_m = 0.2, kScatter_rad = 0.1;

}  // namespace

bool PoseSearch::choose(std::span<const RememberedSight> seen, const FieldAt& odometry) {
  sights_ = 0;
  std::array<bool, SightMemory::kMost> taken{};
  // Repeatedly the best of those that are left: marks, the newest first; then lines, the longest first.
  const auto take = [&](std::size_t most, const auto& worth) {
    while (sights_ < most) {
      double best = 0;
      std::size_t which = seen.size();
      for (std::size_t i = 0; i < seen.size(); ++i)
        if (const double w = taken[i] ? 0 : worth(seen[i]); w > best) best = w, which = i;
      if (which == seen.size()) return;
      taken[which] = true;
      const RememberedSight& s = seen[which];
      const FieldPoint at = odometry.in(s.x_m, s.y_m);
      const double heading = s.heading_rad - odometry.heading_rad;
      ScoredSight& o = sight_[sights_];
      o = {};
      o.kind = s.kind;
      o.x_m = static_cast<float>(at.x_m), o.y_m = static_cast<float>(at.y_m);
      if (s.kind == Kind::line) {
        const math::SinCos t = math::sincos(heading);
        o.ahead = static_cast<float>(t.cos), o.left = static_cast<float>(t.sin);
        o.half_m = static_cast<float>(s.half_m);
        o.per_angle2 = static_cast<float>(1 / (kAngle * kAngle));
      }
      o.per_m2 = static_cast<float>(1 / (kPlace_m * kPlace_m + s.variance_m2));
      sight_heading_[sights_++] = s.kind == Kind::line ? math::kNan : heading;
    }
  };
  take(kMostMarks, [](const RememberedSight& s) {
    return s.kind == Kind::line || s.times < 2 ? 0 : 1e-9 * static_cast<double>(s.seen_ns);
  });
  take(kMostSights, [](const RememberedSight& s) { return s.kind == Kind::line ? s.half_m : 0; });
  return sights_ >= 3;
}

bool PoseSearch::add(double x_m, double y_m, double heading_rad) {
  if (poses_.full() || !field_.holds({x_m, y_m}, kOutside_m)) return false;
  heading_[poses_.count] = math::wrap_pi(heading_rad);
  poses_.add(x_m, y_m, heading_rad);
  return true;
}

void PoseSearch::add_candidates() {
  // The pose at which what was seen at (x, y) of the robot's frame is at a place of the field.
  const auto at_place = [&](const FieldPoint& place, const ScoredSight& o, double heading) {
    const math::SinCos t = math::sincos(heading);
    add(place.x_m - (t.cos * double{o.x_m} - t.sin * double{o.y_m}),
        place.y_m - (t.sin * double{o.x_m} + t.cos * double{o.y_m}), heading);
  };
  const auto right_half = [](const FieldPoint& p) { return p.x_m > 1e-6 || (p.x_m > -1e-6 && p.y_m > -1e-6); };
  const auto line_heading = [](const ScoredSight& o) { return math::atan2(double{o.left}, double{o.ahead}); };
  for (std::size_t i = 0; i < sights_; ++i) {
    const ScoredSight& o = sight_[i];
    const double seen = sight_heading_[i];
    if (o.kind == Kind::line) continue;
    if (!math::is_nan(seen)) {
      for (const FieldCorner& c : field_.corners())
        if (right_half(c.at) && ((c.kind == msg::FieldMark::corner_l && o.kind == Kind::corner_l) ||
                                 (c.kind == msg::FieldMark::corner_t && o.kind == Kind::corner_t)))
          at_place(c.at, o, c.heading_rad - seen);
      if (o.kind == Kind::circle) at_place({0, 0}, o, math::kPi / 2 - seen);
      continue;
    }
    for (std::size_t k = 0; k < sights_; ++k) {
      if (sight_[k].kind != Kind::line) continue;
      for (int quarter = 0; quarter < 4; ++quarter) {
        const double heading = quarter * math::kPi / 2 - line_heading(sight_[k]);
        if (o.kind == Kind::circle && quarter < 2) at_place({0, 0}, o, heading);
        if (o.kind == Kind::penalty_mark) at_place(field_.penalty_marks()[0], o, heading);
      }
    }
  }
  // Two lines that cross: one along x, the other along y.
  const FieldSize& f = field_.size();
  const double x = f.length_m / 2, y = f.width_m / 2;
  const std::array<double, 6> ys{y,
                                 -y,
                                 f.penalty_area_width_m / 2,
                                 -f.penalty_area_width_m / 2,
                                 f.goal_area_width_m / 2,
                                 -f.goal_area_width_m / 2};
  const std::array<double, 7> xs{0,
                                 x,
                                 -x,
                                 x - f.penalty_area_length_m,
                                 f.penalty_area_length_m - x,
                                 x - f.goal_area_length_m,
                                 f.goal_area_length_m - x};
  int pairs = 0;
  for (std::size_t i = 0; i < sights_ && pairs < 4; ++i)
    for (std::size_t k = 0; k < sights_ && pairs < 4; ++k) {
      const ScoredSight &a = sight_[i], &b = sight_[k];
      if (a.kind != Kind::line || b.kind != Kind::line) continue;
      if (math::fabs(double{a.ahead} * b.left - double{a.left} * b.ahead) < 0.95) continue;
      ++pairs;  // `a` along x and `b` along y; the loops come to the other way round, too
      const double heading = -line_heading(a);
      const math::SinCos t = math::sincos(heading);
      const double a_y = t.sin * double{a.x_m} + t.cos * double{a.y_m};
      const double b_x = t.cos * double{b.x_m} - t.sin * double{b.y_m};
      for (const double line_y : ys)
        for (const double line_x : xs) add(line_x - b_x, line_y - a_y, heading);
    }
}

std::size_t PoseSearch::best(std::span<Found> out) const {
  std::size_t count = 0;
  for (std::size_t i = 0; i < poses_.count; ++i) {
    const Found f{{double{poses_.x_m[i]}, double{poses_.y_m[i]}, heading_[i]}, double{poses_.cost[i]}};
    if (count == out.size() && !(f.cost < out[count - 1].cost)) continue;
    const auto alike = [&](const Found& o) {
      const FieldAt m = o.at.mirrored();
      return (distance_m(f.at, o.at) < kApart_m && turn_between_rad(f.at, o.at) < kApart_rad) ||
             (distance_m(f.at, m) < kApart_m && turn_between_rad(f.at, m) < kApart_rad);
    };
    // Of poses that are alike the cheapest stays.
    bool beaten = false;
    std::size_t kept = 0;
    for (std::size_t k = 0; k < count; ++k) {
      if (alike(out[k])) {
        if (out[k].cost <= f.cost) beaten = true;
        if (!beaten) continue;  // f takes its place
      }
      out[kept++] = out[k];
    }
    count = kept;
    if (beaten) continue;
    std::size_t place = count < out.size() ? count++ : count - 1;
    for (; place > 0 && out[place - 1].cost > f.cost; --place) out[place] = out[place - 1];
    out[place] = f;
  }
  return count;
}

void PoseSearch::cost_of(std::span<const FieldAt> poses, std::span<double> costs) {
  poses_.count = 0;
  for (const FieldAt& p : poses) poses_.add(p.x_m, p.y_m, p.heading_rad);
  score_.score({sight_.data(), sights_}, poses_);
  for (std::size_t i = 0; i < poses_.count; ++i) costs[i] = double{poses_.cost[i]};
}

std::span<const PoseSearch::Found> PoseSearch::search(math::Random& random) {
  poses_.count = 0;
  add_candidates();
  if (poses_.count == 0) return {};
  score_.score({sight_.data(), sights_}, poses_);
  const std::size_t first = best(found_);
  if (first == 0) return {};
  const std::array<Found, kMostFound> centres = found_;
  poses_.count = 0;
  const std::size_t each = 500 / first;
  for (std::size_t c = 0; c < first; ++c)
    for (std::size_t k = 0; k < each; ++k) {
      const FieldAt& at = centres[c].at;
      const double share = k == 0 ? 0 : 1;  // itself, too
      const double dx = random.uniform(-kScatter_m, kScatter_m), dy = random.uniform(-kScatter_m, kScatter_m);
      add(at.x_m + share * dx, at.y_m + share * dy,
          at.heading_rad + share * random.uniform(-kScatter_rad, kScatter_rad));
    }
  score_.score({sight_.data(), sights_}, poses_);
  return {found_.data(), best(found_)};
}

}  // namespace sinew::soccer
