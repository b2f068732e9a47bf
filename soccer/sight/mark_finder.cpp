#include "soccer/sight/mark_finder.hpp"

#include <algorithm>

namespace sinew::soccer {
namespace {

constexpr double kPast_m = 0.45;         // by which lines may end before the corner
constexpr double kMarkFarthest_m = 4.5;  // beyond it a line is thinner than a pixel
constexpr double kRing_m = 0.3, kSame_m = 0.3;

enum class Arm : std::uint8_t { unknown, absent, present };

/// Whether a line goes from `from` along `way` (a unit vector).
Arm arm(const Picture& picture, const GroundView& view, const GroundXy& from, const GroundXy& way) {
  const double d2 = (from.x_m - view.camera_m().x) * (from.x_m - view.camera_m().x) +
                    (from.y_m - view.camera_m().y) * (from.y_m - view.camera_m().y);
  const double h = view.height_m();
  const double pixel_m = (d2 + h * h) / (h * view.camera().fx_px);
  const double across = std::max(0.015, 0.6 * pixel_m);
  constexpr int kSteps = 8;
  int line = 0, carpet = 0;
  for (int k = 0; k < kSteps; ++k) {
    const double s = 0.1 + std::max(0.0, pixel_m - 0.03) + 0.04 * k;
    int here = 0, green = 0;
    for (int side = -1; side <= 1; ++side) {
      const double x = from.x_m + s * way.x_m - side * across * way.y_m;
      const double y = from.y_m + s * way.y_m + side * across * way.x_m;
      const Probe p = probe(picture, view, {x, y});
      if (p == Probe::unseen) return Arm::unknown;
      here += p == Probe::line;
      green += p == Probe::carpet;
    }
    line += here > 0;
    carpet += green == 3;
  }
  if (line >= kSteps - 1) return Arm::present;
  return carpet >= kSteps - 2 && line <= 1 ? Arm::absent : Arm::unknown;
}

}  // namespace

void MarkFinder::add(const GroundView& view, const GroundXy& at, msg::FieldMark kind, double heading_rad) {
  for (std::size_t i = 0; i < count_; ++i)
    if (math::hypot(mark_[i].at.x_m - at.x_m, mark_[i].at.y_m - at.y_m) < kSame_m && kind != msg::FieldMark::circle &&
        mark_[i].kind != msg::FieldMark::circle)
      return;
  if (count_ == kMost) return;
  msg::SeenMark& m = mark_[count_++];
  m = {};
  m.at = view.with_covariance(at, 1.5 * view.errors().pixel_px);
  m.kind = kind;
  m.heading_rad = static_cast<float>(math::canonical(heading_rad));
  const double d = math::hypot(at.x_m - view.camera_m().x, at.y_m - view.camera_m().y);
  m.heading_sigma_rad = math::is_nan(heading_rad) ? math::kNanF : static_cast<float>(0.03 + 0.03 * d);
}

void MarkFinder::add_corner(const Picture& picture, const GroundView& view, const LinePiece& a, const LinePiece& b) {
  const double la = a.length_m(), lb = b.length_m();
  const GroundXy da{(a.to.x_m - a.from.x_m) / la, (a.to.y_m - a.from.y_m) / la};
  const GroundXy db{(b.to.x_m - b.from.x_m) / lb, (b.to.y_m - b.from.y_m) / lb};
  const double turn = da.x_m * db.y_m - da.y_m * db.x_m;  // sine of the angle between
  if (math::fabs(turn) < 0.9) return;
  const double dx = b.from.x_m - a.from.x_m, dy = b.from.y_m - a.from.y_m;
  const double s = (dx * db.y_m - dy * db.x_m) / turn, t = (dx * da.y_m - dy * da.x_m) / turn;
  if (s < -kPast_m || s > la + kPast_m || t < -kPast_m || t > lb + kPast_m) return;
  const GroundXy at{a.from.x_m + s * da.x_m, a.from.y_m + s * da.y_m};
  if (math::hypot(at.x_m - view.camera_m().x, at.y_m - view.camera_m().y) > kMarkFarthest_m) return;
  const GroundXy way[4] = {da, {-da.x_m, -da.y_m}, db, {-db.x_m, -db.y_m}};
  bool there[4] = {};
  int present = 0;
  for (int k = 0; k < 4; ++k) {
    const Arm found = arm(picture, view, at, way[k]);
    if (found == Arm::unknown) return;
    there[k] = found == Arm::present;
    present += there[k];
  }
  const auto heading = [](const GroundXy& w) { return math::atan2(w.y_m, w.x_m); };
  // Four arms: on a field only where the circle crosses the halfway line, and that was right in 2 of 23 sightings.
  if (present == 4) return;
  if (present == 3) {  // the line of which one arm is absent ends here
    const int ends = !there[0] ? 1 : !there[1] ? 0 : !there[2] ? 3 : 2;
    return add(view, at, msg::FieldMark::corner_t, heading(way[ends]));
  }
  if (present == 2 && there[0] != there[1] && there[2] != there[3]) {
    const GroundXy &p = there[0] ? way[0] : way[1], &q = there[2] ? way[2] : way[3];
    add(view, at, msg::FieldMark::corner_l, heading({p.x_m + q.x_m, p.y_m + q.y_m}));
  }
}

void MarkFinder::find(const Picture& picture, const GroundView& view, const LineFinder& lines,
                      std::span<const LinePoint> points) {
  count_ = 0;
  if (lines.circle()) {
    // Along the halfway line, if a line goes through the centre.
    double heading = math::kNan;
    const GroundXy& c = lines.circle()->centre;
    for (const LinePiece& l : lines.lines()) {
      const double length = l.length_m();
      const double x = (l.to.x_m - l.from.x_m) / length, y = (l.to.y_m - l.from.y_m) / length;
      const double off = x * (c.y_m - l.from.y_m) - y * (c.x_m - l.from.x_m);
      if (math::fabs(off) < 0.15 && length > 0.8) heading = math::atan2(y, x);
    }
    add(view, c, msg::FieldMark::circle, heading);
  }
  const auto all = lines.lines();
  for (std::size_t i = 0; i < all.size(); ++i)
    for (std::size_t k = i + 1; k < all.size(); ++k) add_corner(picture, view, all[i], all[k]);

  for (std::size_t i = 0; i < points.size(); ++i) {
    if (lines.owner(i) != 0) continue;
    double x = 0, y = 0, n = 0;
    for (std::size_t k = 0; k < points.size(); ++k) {
      if (math::hypot(points[k].x_m - points[i].x_m, points[k].y_m - points[i].y_m) > 0.17) continue;
      x += points[k].x_m, y += points[k].y_m, n += 1;
    }
    if (n < 3) continue;
    const GroundXy at{x / n, y / n};
    if (math::hypot(at.x_m - view.camera_m().x, at.y_m - view.camera_m().y) > 3) continue;
    constexpr int kAround = 16;
    int carpet = 0;
    for (int a = 0; a < kAround; ++a) {
      const math::SinCos t = math::sincos(2 * math::kPi * a / kAround);
      carpet += probe(picture, view, {at.x_m + kRing_m * t.cos, at.y_m + kRing_m * t.sin}) == Probe::carpet;
    }
    if (carpet == kAround && probe(picture, view, at) == Probe::line)
      add(view, at, msg::FieldMark::penalty_mark, math::kNan);
  }
}

}  // namespace sinew::soccer
