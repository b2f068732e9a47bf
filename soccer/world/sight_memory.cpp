#include "soccer/world/sight_memory.hpp"

#include <algorithm>

namespace sinew::soccer {
namespace {

using Kind = ScoredSight::Kind;
constexpr double kSameMark_m = 0.35, kSameLine_m = 0.25, kSameLine_rad = 0.3;  // sightings of one thing
constexpr double kShortestLine_m = 0.3, kRemembered_m = 4.5;

Kind kind_of(msg::FieldMark mark) {
  switch (mark) {
    case msg::FieldMark::corner_l:
      return Kind::corner_l;
    case msg::FieldMark::corner_t:
      return Kind::corner_t;
    case msg::FieldMark::corner_x:
      return Kind::corner_x;
    case msg::FieldMark::penalty_mark:
      return Kind::penalty_mark;
    case msg::FieldMark::circle:
      break;
  }
  return Kind::circle;
}

/// Of directions that mean the same after half a turn.
double turn_between_lines(double a, double b) {
  const double turn = math::fabs(math::wrap_pi(a - b));
  return std::min(turn, math::kPi - turn);
}

bool same_thing(const RememberedSight& a, const RememberedSight& b) {
  if (a.kind != b.kind) return false;
  if (a.kind != Kind::line) return math::hypot(a.x_m - b.x_m, a.y_m - b.y_m) < kSameMark_m;
  if (turn_between_lines(a.heading_rad, b.heading_rad) > kSameLine_rad) return false;
  const math::SinCos t = math::sincos(a.heading_rad);
  const double dx = b.x_m - a.x_m, dy = b.y_m - a.y_m;
  return math::fabs(t.cos * dy - t.sin * dx) < kSameLine_m &&
         math::fabs(t.cos * dx + t.sin * dy) < a.half_m + b.half_m + kSameMark_m;
}

}  // namespace

void SightMemory::add(const RememberedSight& s) {
  for (std::size_t i = 0; i < count_; ++i) {
    RememberedSight& old = sight_[i];
    if (!same_thing(old, s)) continue;
    const std::uint32_t times = old.times + 1;
    const bool keeps_place = s.kind == Kind::line && s.half_m < 0.7 * old.half_m;
    const double heading = math::is_nan(s.heading_rad) ? old.heading_rad : s.heading_rad;
    if (!keeps_place) old = s;
    old.heading_rad = keeps_place ? old.heading_rad : heading;
    old.times = times, old.seen_ns = s.seen_ns;
    return;
  }
  if (count_ < kMost) {
    sight_[count_++] = s;
    return;
  }
  *std::ranges::min_element(sight_, {}, &RememberedSight::seen_ns) = s;
}

void SightMemory::see(const msg::SoccerSight& sight, double keep_s) {
  const std::int64_t oldest = sight.stamp.ns - static_cast<std::int64_t>(1e9 * keep_s);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < count_; ++i)
    if (sight_[i].seen_ns >= oldest) sight_[kept++] = sight_[i];
  count_ = static_cast<std::uint32_t>(kept);

  const FieldAt robot{sight.x_m, sight.y_m, sight.heading_rad};
  for (std::uint32_t i = 0; i < std::min<std::size_t>(sight.lines, sight.line.size()); ++i) {
    const msg::GroundPoint &a = sight.line[i].from, &b = sight.line[i].to;
    const double dx = b.x_m - a.x_m, dy = b.y_m - a.y_m, length = math::hypot(dx, dy);
    const double x = 0.5 * (double{a.x_m} + b.x_m), y = 0.5 * (double{a.y_m} + b.y_m);
    if (!(length > kShortestLine_m) || !(math::hypot(x, y) < kRemembered_m)) continue;
    const double nx = -dy / length, ny = dx / length;
    const auto across = [&](const msg::GroundPoint& p) {
      return nx * nx * p.xx_m2 + 2 * nx * ny * p.xy_m2 + ny * ny * p.yy_m2;
    };
    const FieldPoint at = robot.out(x, y);
    add({Kind::line, 1, at.x_m, at.y_m, math::wrap_pi(robot.heading_rad + math::atan2(dy, dx)), 0.5 * length,
         0.5 * (across(a) + across(b)), sight.stamp.ns});
  }
  for (std::uint32_t i = 0; i < std::min<std::size_t>(sight.marks, sight.mark.size()); ++i) {
    const msg::SeenMark& m = sight.mark[i];
    if (!(math::hypot(m.at.x_m, m.at.y_m) < kRemembered_m)) continue;
    const FieldPoint at = robot.out(m.at.x_m, m.at.y_m);
    add({kind_of(m.kind), 1, at.x_m, at.y_m, math::wrap_pi(robot.heading_rad + m.heading_rad), 0,
         0.5 * (double{m.at.xx_m2} + m.at.yy_m2), sight.stamp.ns});
  }
}

}  // namespace sinew::soccer
