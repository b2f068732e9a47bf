#include "soccer/sight/line_finder.hpp"

#include <algorithm>
#include <bit>

namespace sinew::soccer {
namespace {

constexpr int kLineSamples = 90, kCircleSamples = 90, kLeastPoints = 5, kLeastOfCircle = 12;
constexpr double kLeastLength_m = 0.3, kLargestGap_m = 0.7, kNearPixels = 90;
constexpr double kMostOnLines = 0.7;  // of a circle's points, on two straight lines: more is a corner
constexpr double kSameCentre_m = 0.22, kLeastTurn_rad = 0.35, kBend_px = 0.5, kLongest_m = 1.3;
constexpr std::uint8_t kOfBent = 253, kOfCircle = 255, kOfNone = 0, kDropped = 254;

double tolerance_px(const Picture& picture) { return 0.9 + 0.0016 * picture.width(); }

/// On the ground: noise of the picture and a tilt that bends the circle.
double tolerance_m(double distance_m) { return 0.04 + 0.025 * distance_m; }

struct Straight {
  double a = 0, b = 0, c = 0;  // a u + b v + c = 0, a^2 + b^2 = 1
  double off(double u, double v) const { return a * u + b * v + c; }
};

/// Total least squares through points that `use` has.
template <class Use>
int fit(std::span<const LinePoint> points, const Use& use, Straight& line) {
  double n = 0, su = 0, sv = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (use(i)) n += 1, su += points[i].u_px, sv += points[i].v_px;
  if (n < 2) return 0;
  const double mu = su / n, mv = sv / n;
  double uu = 0, uv = 0, vv = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!use(i)) continue;
    const double du = points[i].u_px - mu, dv = points[i].v_px - mv;
    uu += du * du, uv += du * dv, vv += dv * dv;
  }
  const double turn = 0.5 * math::atan2(2 * uv, uu - vv);
  const math::SinCos t = math::sincos(turn);
  line = {-t.sin, t.cos, t.sin * mu - t.cos * mv};
  return static_cast<int>(n);
}

}  // namespace

Probe probe(const Picture& picture, const GroundView& view, const GroundXy& p) {
  const PixelAt at = view.pixel(p);
  if (!(at.depth_m > 0) || !picture.holds(at.u_px, at.v_px)) return Probe::unseen;
  const int x = static_cast<int>(at.u_px + 0.5), y = static_cast<int>(at.v_px + 0.5);
  switch (picture.at(x, y)) {
    case Colour::carpet:
      return Probe::carpet;
    case Colour::white:
      return Probe::line;
    case Colour::other: {  // the edge of a line, or a thin one that is mixed with carpet
      const int side = std::max(picture.luma(std::max(0, x - 1), y), picture.luma(x, std::max(0, y - 1)));
      return picture.luma(x, y) * 8 >= side * 7 ? Probe::line : Probe::other;
    }
    case Colour::dark:
    case Colour::blue:
    case Colour::red:
      break;
  }
  return Probe::other;
}

std::uint32_t LineFinder::random(std::uint32_t below) {
  draw_ = draw_ * 1664525U + 1013904223U;  // Numerical Recipes' generator; its upper half is used
  return (draw_ >> 16) % below;
}

void LineFinder::find(const Picture& picture, const GroundView& view, std::span<const LinePoint> points,
                      double circle_radius_m) {
  draw_ = 1;
  lines_ = 0;
  circle_.reset();
  std::fill_n(owner_.begin(), points.size(), kOfNone);
  find_circle(picture, view, points, circle_radius_m);
  for (std::size_t i = 0; i < kMost + 4 && lines_ < kMost; ++i)
    if (!find_line(picture, view, points)) break;
  if (!circle_) circle_of_chords(picture, view, points, circle_radius_m);
  // What is bent is no straight line, whether the circle was found or not.
  std::size_t kept = 0;
  std::array<std::uint8_t, kMost + 1> number{};
  for (std::size_t i = 0; i < lines_; ++i) {
    if (line_[i].is_bent) continue;
    number[i + 1] = static_cast<std::uint8_t>(kept + 1);
    line_[kept++] = line_[i];
  }
  lines_ = kept;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (owner_[i] == kDropped) owner_[i] = kOfNone;
    if (owner_[i] != kOfCircle && owner_[i] != kOfNone)
      owner_[i] = number[owner_[i]] != 0 ? number[owner_[i]] : kOfBent;
  }
}

void LineFinder::circle_of_chords(const Picture& picture, const GroundView& view, std::span<const LinePoint> points,
                                  double radius_m) {
  // Each short line is a chord of a circle on its left or its right.
  struct Chord {
    GroundXy centre;
    double turn;
    std::size_t line;
  };
  std::array<Chord, 2 * kMost> chord{};
  std::size_t n = 0;
  for (std::size_t i = 0; i < lines_; ++i) {
    const LinePiece& l = line_[i];
    const double length = l.length_m();
    if (length > 1.5 * radius_m) continue;
    // A chord through the middle of the strip lies between the arc and its ends' line: by two thirds of the sagitta.
    const double high = math::sqrt(radius_m * radius_m - 0.25 * length * length);
    const double off = high + 0.6667 * (radius_m - high);
    const double x = (l.to.x_m - l.from.x_m) / length, y = (l.to.y_m - l.from.y_m) / length;
    for (const double side : {off, -off})
      chord[n++] = {
          {0.5 * (l.from.x_m + l.to.x_m) - side * y, 0.5 * (l.from.y_m + l.to.y_m) + side * x}, math::atan2(y, x), i};
  }
  for (std::size_t i = 0; i < n; ++i) {
    double sx = 0, sy = 0, most_turn = 0;
    int count = 0;
    for (std::size_t k = 0; k < n; ++k) {
      const double d =
          math::hypot(chord[k].centre.x_m - chord[i].centre.x_m, chord[k].centre.y_m - chord[i].centre.y_m);
      if (d > kSameCentre_m) continue;
      sx += chord[k].centre.x_m, sy += chord[k].centre.y_m, ++count;
      const double turn = math::fabs(math::wrap_pi(2 * (chord[k].turn - chord[i].turn))) / 2;
      most_turn = std::max(most_turn, turn);
    }
    if (count < 2 || most_turn < kLeastTurn_rad) continue;
    const GroundXy centre{sx / count, sy / count};
    int seen = 0, line = 0;
    constexpr int kAround = 48;
    for (int k = 0; k < kAround; ++k) {
      const math::SinCos t = math::sincos(2 * math::kPi * k / kAround);
      const auto look = [&](double at) {
        return probe(picture, view, {centre.x_m + at * t.cos, centre.y_m + at * t.sin});
      };
      if (look(radius_m) == Probe::unseen) continue;
      ++seen;
      bool any = false;
      for (const double more : {-0.1, -0.06, -0.03, 0.0, 0.03, 0.06, 0.1})
        any = any || look(radius_m + more) == Probe::line;
      line += any;
    }
    if (seen < 10 || line * 10 < seen * 8) continue;
    CirclePiece found{centre, radius_m, 0};
    for (std::size_t k = 0; k < points.size(); ++k) {
      const double d = math::hypot(points[k].x_m - centre.x_m, points[k].y_m - centre.y_m);
      if (math::fabs(d - radius_m) > 0.15) continue;
      owner_[k] = kOfCircle;
      ++found.points;
    }
    for (std::size_t k = 0; k < n; ++k)
      if (math::hypot(chord[k].centre.x_m - centre.x_m, chord[k].centre.y_m - centre.y_m) < kSameCentre_m)
        line_[chord[k].line].is_bent = true;
    circle_ = found;
    return;
  }
}

template <class Use>
double LineFinder::two_lines_share(const Picture& picture, std::span<const LinePoint> points, const Use& use) {
  std::array<std::uint16_t, LinePoints::kMost> left{};
  std::uint32_t n = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (use(i)) left[n++] = static_cast<std::uint16_t>(i);
  const std::uint32_t all = n;
  const double tol = tolerance_px(picture);
  for (int line = 0; line < 2 && n >= 2; ++line) {
    std::uint32_t best = 0;
    Straight most;
    for (int k = 0; k < 30; ++k) {
      const LinePoint &p = points[left[random(n)]], &q = points[left[random(n)]];
      const double du = q.u_px - p.u_px, dv = q.v_px - p.v_px, length = math::sqrt(du * du + dv * dv);
      if (length < 4) continue;
      const Straight s{-dv / length, du / length, (dv * p.u_px - du * p.v_px) / length};
      std::uint32_t count = 0;
      for (std::uint32_t m = 0; m < n; ++m)
        count += math::fabs(s.off(points[left[m]].u_px, points[left[m]].v_px)) < tol;
      if (count > best) best = count, most = s;
    }
    std::uint32_t kept = 0;
    for (std::uint32_t m = 0; m < n; ++m)
      if (best == 0 || !(math::fabs(most.off(points[left[m]].u_px, points[left[m]].v_px)) < tol))
        left[kept++] = left[m];
    n = kept;
  }
  return 1 - static_cast<double>(n) / std::max(1U, all);
}

void LineFinder::find_circle(const Picture& picture, const GroundView& view, std::span<const LinePoint> points,
                             double radius_m) {
  if (points.size() < kLeastOfCircle || !(radius_m > 0)) return;
  std::array<float, LinePoints::kMost> tolerance{};
  for (std::size_t i = 0; i < points.size(); ++i)
    tolerance[i] = static_cast<float>(
        tolerance_m(math::hypot(points[i].x_m - view.camera_m().x, points[i].y_m - view.camera_m().y)));
  const auto n = static_cast<std::uint32_t>(points.size());
  const auto inliers = [&](double cx, double cy, double r) {
    int count = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double dx = points[i].x_m - cx, dy = points[i].y_m - cy, d2 = dx * dx + dy * dy;
      const double low = r - tolerance[i], high = r + tolerance[i];
      count += static_cast<int>(d2 > low * low) & static_cast<int>(d2 < high * high);
    }
    return count;
  };
  int best = kLeastOfCircle - 1;
  GroundXy centre;
  for (int k = 0; k < kCircleSamples; ++k) {
    const LinePoint &a = points[random(n)], &b = points[random(n)];
    const double dx = b.x_m - a.x_m, dy = b.y_m - a.y_m, d2 = dx * dx + dy * dy;
    if (d2 < 0.25 * radius_m * radius_m || d2 > 3.6 * radius_m * radius_m) continue;
    const double up = math::sqrt(radius_m * radius_m / d2 - 0.25);
    for (const double side : {up, -up}) {
      const double cx = 0.5 * (a.x_m + b.x_m) - side * dy, cy = 0.5 * (a.y_m + b.y_m) + side * dx;
      const int count = inliers(cx, cy, radius_m);
      if (count > best) best = count, centre = {cx, cy};
    }
  }
  if (best < kLeastOfCircle) return;
  // Centre and radius by the algebraic fit, twice.
  double r = radius_m;
  const auto on = [&](std::size_t i) {
    const double d = math::hypot(points[i].x_m - centre.x_m, points[i].y_m - centre.y_m);
    return math::fabs(d - r) < tolerance[i];
  };
  for (int round = 0; round < 2; ++round) {
    double m = 0, sx = 0, sy = 0;
    for (std::size_t i = 0; i < points.size(); ++i)
      if (on(i)) m += 1, sx += points[i].x_m, sy += points[i].y_m;
    if (m < kLeastOfCircle) return;
    const double mx = sx / m, my = sy / m;
    double xx = 0, xy = 0, yy = 0, xz = 0, yz = 0, z = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!on(i)) continue;
      const double x = points[i].x_m - mx, y = points[i].y_m - my, s = x * x + y * y;
      xx += x * x, xy += x * y, yy += y * y, xz += x * s, yz += y * s, z += s;
    }
    const double det = xx * yy - xy * xy;
    if (!(det > 1e-6)) return;
    const double cx = 0.5 * (yy * xz - xy * yz) / det, cy = 0.5 * (xx * yz - xy * xz) / det;
    centre = {mx + cx, my + cy};
    r = math::sqrt(cx * cx + cy * cy + z / m);
    if (!(r > 0.8 * radius_m && r < 1.25 * radius_m)) return;
  }
  // Round it lies a line, with carpet on both sides.
  int seen = 0, line = 0, clean = 0;
  constexpr int kAround = 36;
  for (int k = 0; k < kAround; ++k) {
    const math::SinCos t = math::sincos(2 * math::kPi * k / kAround);
    const auto look = [&](double at) {
      return probe(picture, view, {centre.x_m + at * t.cos, centre.y_m + at * t.sin});
    };
    const double d =
        math::hypot(centre.x_m + r * t.cos - view.camera_m().x, centre.y_m + r * t.sin - view.camera_m().y);
    const double tol = tolerance_m(d);
    const Probe middle = look(r);
    if (middle == Probe::unseen) continue;
    ++seen;
    line += middle == Probe::line || look(r + 0.4 * tol) == Probe::line || look(r - 0.4 * tol) == Probe::line;
    clean += (look(r - 0.06 - tol) == Probe::carpet) + (look(r + 0.06 + tol) == Probe::carpet);
  }
  if (seen < 10 || line * 10 < seen * 7 || clean * 10 < seen * 14) return;
  // Its points are on at least a third of its turn: less could be a corner.
  std::uint32_t sectors = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (on(i)) {
      const double turn = math::atan2(points[i].y_m - centre.y_m, points[i].x_m - centre.x_m) / (2 * math::kPi) + 0.5;
      sectors |= 1U << std::min(11, static_cast<int>(turn * 12));
    }
  if (std::popcount(sectors) < 5) return;
  if (two_lines_share(picture, points, on) > kMostOnLines) return;
  CirclePiece found{centre, r, 0};
  for (std::size_t i = 0; i < points.size(); ++i)
    if (on(i)) owner_[i] = kOfCircle, ++found.points;
  circle_ = found;
}

bool LineFinder::find_line(const Picture& picture, const GroundView& view, std::span<const LinePoint> points) {
  std::array<std::uint16_t, LinePoints::kMost> free{};
  std::array<float, LinePoints::kMost> u{}, v{};
  std::uint32_t n = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (owner_[i] != kOfNone) continue;
    u[n] = points[i].u_px, v[n] = points[i].v_px;
    free[n++] = static_cast<std::uint16_t>(i);
  }
  if (n < kLeastPoints) return false;
  const auto tol = static_cast<float>(tolerance_px(picture));
  const double near = kNearPixels * picture.width() / 320;
  int best = kLeastPoints - 1;
  Straight line;
  for (int k = 0; k < kLineSamples; ++k) {
    const std::uint32_t i = random(n);
    std::uint32_t j = random(n);
    for (int tries = 0; tries < 6; ++tries, j = random(n)) {
      const double du = u[j] - u[i], dv = v[j] - v[i], d2 = du * du + dv * dv;
      if (d2 > 36 && d2 < near * near) break;
    }
    const float du = u[j] - u[i], dv = v[j] - v[i], length = math::sqrt(du * du + dv * dv);
    if (length < 4) continue;
    const float a = -dv / length, b = du / length, c = -(a * u[i] + b * v[i]);
    int count = 0;
    for (std::uint32_t m = 0; m < n; ++m) {
      const float off = a * u[m] + b * v[m] + c;
      count += static_cast<int>(off < tol) & static_cast<int>(off > -tol);
    }
    if (count > best) best = count, line = {a, b, c};
  }
  if (best < kLeastPoints) return false;
  const auto on = [&](std::size_t i) {
    return owner_[i] == kOfNone && math::fabs(line.off(points[i].u_px, points[i].v_px)) < tol;
  };
  for (int round = 0; round < 2; ++round)
    if (fit(
            points, [&](std::size_t i) { return on(i); }, line) < kLeastPoints)
      break;

  // In order along the line; the longest stretch without a large gap.
  std::array<std::pair<float, std::uint16_t>, LinePoints::kMost> order{};
  std::size_t count = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (on(i))
      order[count++] = {static_cast<float>(line.b * points[i].u_px - line.a * points[i].v_px),
                        static_cast<std::uint16_t>(i)};
  if (count < 2) return false;
  std::sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count));
  std::size_t from = 0, to = 0, first = 0;
  for (std::size_t k = 1; k <= count; ++k) {
    if (k < count) {
      const LinePoint &p = points[order[k - 1].second], &q = points[order[k].second];
      const double gap = math::hypot(p.x_m - q.x_m, p.y_m - q.y_m);
      if (gap < kLargestGap_m || order[k].first - order[k - 1].first < 8) continue;
    }
    if (k - first > to - from) from = first, to = k;
    first = k;
  }
  const auto on_line = [&](const LinePoint& p, double& pu, double& pv) {
    const double off = line.off(p.u_px, p.v_px);
    pu = p.u_px - off * line.a, pv = p.v_px - off * line.b;
  };
  LinePiece piece;
  piece.points = static_cast<int>(to - from);
  on_line(points[order[from].second], piece.u0_px, piece.v0_px);
  on_line(points[order[to - 1].second], piece.u1_px, piece.v1_px);
  const auto a = view.ground(piece.u0_px, piece.v0_px), b = view.ground(piece.u1_px, piece.v1_px);
  bool good = a && b && piece.points >= kLeastPoints;
  if (good) {
    piece.from = *a, piece.to = *b;
    good = piece.length_m() >= kLeastLength_m;
  }
  if (good) {
    constexpr int kAlong = 16;
    int line_seen = 0;
    for (int k = 0; k < kAlong; ++k) {
      const double s = (k + 0.5) / kAlong;
      const GroundXy p{piece.from.x_m + s * (piece.to.x_m - piece.from.x_m),
                       piece.from.y_m + s * (piece.to.y_m - piece.from.y_m)};
      line_seen += probe(picture, view, p) != Probe::carpet;
    }
    good = line_seen * 10 >= kAlong * 6;
  }
  for (std::size_t k = 0; k < count; ++k)
    if (k >= from && k < to) owner_[order[k].second] = good ? static_cast<std::uint8_t>(lines_ + 1) : kDropped;
  if (good && piece.length_m() < kLongest_m) {
    // The middle third of its points against the outer ones.
    double middle = 0, outer = 0, m = 0, o = 0;
    for (std::size_t k = from; k < to; ++k) {
      const LinePoint& p = points[order[k].second];
      const double off = line.off(p.u_px, p.v_px);
      const double at = (order[k].first - order[from].first) / std::max(1.0F, order[to - 1].first - order[from].first);
      if (at > 0.3 && at < 0.7)
        middle += off, m += 1;
      else
        outer += off, o += 1;
    }
    piece.is_bent = m > 0 && o > 0 && math::fabs(middle / m - outer / o) > kBend_px * picture.width() / 320;
  }
  if (good) line_[lines_++] = piece;
  return true;
}

}  // namespace sinew::soccer
