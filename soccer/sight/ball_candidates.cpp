#include "soccer/sight/ball_candidates.hpp"

#include <algorithm>

namespace sinew::soccer {
namespace {

constexpr double kSmall_px = 4.5, kMiddle_px = 14;  // radii at which one size ends and the next begins
constexpr double kSmallest_px = 2.8, kLeastStart = 0.34, kLeastFit = 0.4;
constexpr double kSizeError = 0.1, kSizeErrorPerMetre = 0.08;  // of the expected radius

Picture::Count box(const Picture& p, double u, double v, double half_u, double half_v) {
  // Rounded to the nearest; what is left of the picture is cut away, however it was rounded.
  const auto at = [](double x) { return static_cast<int>(x + 1024.5) - 1024; };
  return p.not_carpet(at(u - half_u), at(v - half_v), at(u + half_u), at(v + half_v));
}

/// How much of a disc is no carpet, less how much of the ring round it is not. A ball before a dark robot is brighter
/// than what is round it: the better of both counts.
double fit_of(const Picture& p, double u, double v, double r) {
  const Picture::Count wide = box(p, u, v, 0.9 * r, 0.5 * r), high = box(p, u, v, 0.5 * r, 0.9 * r);
  const Picture::Count inner = box(p, u, v, 1.12 * r, 1.12 * r), outer = box(p, u, v, 1.5 * r, 1.5 * r);
  const double disc = 1.0 / std::max(1, wide.all + high.all), ring = 0.7 / std::max(1, outer.all - inner.all);
  return std::max((wide.other + high.other) * disc - (outer.other - inner.other) * ring,
                  (wide.bright + high.bright) * disc - (outer.bright - inner.bright) * ring);
}

}  // namespace

double BallCandidates::fit(const Picture& picture, double u_px, double v_px, double radius_px) {
  return fit_of(picture, u_px, v_px, radius_px);
}

void BallCandidates::add(const BallCandidate& c) {
  // One for each place: the better one stays.
  for (const bool remove : {false, true})
    for (List& l : list_)
      for (std::size_t i = 0; i < l.count; ++i) {
        const BallCandidate& o = l.item[i];
        const double du = c.u_px - o.u_px, dv = c.v_px - o.v_px, r = 0.7 * std::max(c.radius_px, o.radius_px);
        if (du * du + dv * dv > r * r) continue;
        if (c.fit <= o.fit) return;
        if (!remove) continue;
        for (std::size_t k = i; k + 1 < l.count; ++k) l.item[k] = l.item[k + 1];
        --l.count, --i;
      }
  List& l = list_[c.expected_px < kSmall_px ? 0 : c.expected_px < kMiddle_px ? 1 : 2];
  std::size_t at = l.count;
  while (at > 0 && l.item[at - 1].fit < c.fit) --at;
  if (at == kMostOfSize) return;
  l.count = std::min(l.count + 1, kMostOfSize);
  for (std::size_t k = l.count - 1; k > at; --k) l.item[k] = l.item[k - 1];
  l.item[at] = c;
}

bool BallCandidates::near(double u_px, double v_px, double within_px) const {
  for (const List& l : list_)
    for (std::size_t i = 0; i < l.count; ++i) {
      const double du = l.item[i].u_px - u_px, dv = l.item[i].v_px - v_px;
      if (du * du + dv * dv < within_px * within_px) return true;
    }
  return false;
}

void BallCandidates::find(const Picture& picture, const GroundView& view, const FieldBorder& border,
                          double ball_radius_m) {
  count_ = 0;
  for (List& l : list_) l.count = 0;
  const int w = picture.width(), h = picture.height();
  const double middle = 0.5 * (w - 1);
  for (double v = std::max(0.0, std::min(view.horizon_px(0), view.horizon_px(w - 1))); v < h + 20.0;) {
    const auto row_radius = view.ball_radius_px(middle, v, ball_radius_m);
    const double step = row_radius ? std::max(1.5, 0.5 * *row_radius) : 1;
    const double row = v;
    v += step;
    if (!row_radius || *row_radius < 0.7 * kSmallest_px) continue;
    if (*row_radius > 0.6 * h) break;
    for (double u = 0; u < w; u += step) {
      const double r0 = *row_radius;
      const Picture::Count core = box(picture, u, row, 0.45 * r0, 0.45 * r0);
      if (core.other * 2 < core.all || core.all == 0) continue;
      if (row + r0 < border.row_px(u)) continue;  // its foot would be beyond the carpet
      if (fit_of(picture, u, row, r0) < kLeastStart || near(u, row, 0.45 * r0)) continue;
      const auto expected = view.ball_radius_px(u, row, ball_radius_m);
      if (!expected || *expected < kSmallest_px) continue;
      BallCandidate c{u, row, *expected, *expected, fit_of(picture, u, row, *expected)};
      // Moved and resized until nothing near fits better.
      // The farther away, the more the camera's tilt matters for the size.
      const double most = 1 + kSizeError + kSizeErrorPerMetre * view.camera().fx_px * ball_radius_m / *expected;
      double move = 0.35 * c.radius_px, grow = 1.15;
      for (int round = 0; round < 6 && move > 0.4; ++round) {
        const BallCandidate from = c;
        for (int k = 0; k < 6; ++k) {
          BallCandidate t = from;
          if (k < 2) t.u_px += k == 0 ? move : -move;
          if (k >= 2 && k < 4) t.v_px += k == 2 ? move : -move;
          if (k >= 4) t.radius_px = k == 4 ? t.radius_px * grow : t.radius_px / grow;
          if (t.radius_px * most < c.expected_px || t.radius_px > most * c.expected_px) continue;
          t.fit = fit_of(picture, t.u_px, t.v_px, t.radius_px);
          if (t.fit > c.fit + 1e-9) c = t;
        }
        if (c.fit == from.fit) move *= 0.5, grow = 1 + 0.5 * (grow - 1);
      }
      if (c.fit >= kLeastFit) add(c);
    }
  }
  for (const List& l : list_)
    for (std::size_t i = 0; i < l.count; ++i) candidate_[count_++] = l.item[i];
}

}  // namespace sinew::soccer
