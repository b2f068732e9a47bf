#pragma once
#include <cstddef>
#include <span>

namespace sinew::vision {

struct PointPx {
  double x = 0, y = 0;
};

struct Circle {
  double x = 0, y = 0, radius = 0;
  double rms = 0;  // of the points' distances from the circle
  bool valid = false;
};

/// The circle through noisy points of its outline, also when only an arc is known. Not valid for fewer than three
/// points, or points on a line.
/// Thread:  any.   RT: yes.
/// Source:  G. Taubin, "Estimation of planar curves...", PAMI 13 (1991) 1115, solved by Newton's method from zero.
Circle fit_circle(std::span<const PointPx> points);

/// A confidence from any measure of agreement: 0 to 1.
inline double clamp_share(double v) { return v < 0 ? 0 : v > 1 ? 1 : v; }

/// Limits for stray points: a point with a larger distance from the circle is left out. With a small rms the limit is
/// `smooth_px`, else `factor` * rms.
struct StrayLimits {
  double smooth_rms_px, smooth_px, factor;
  std::size_t min_points;  // fewer make no outline
};

struct Outline {
  Circle circle;
  std::size_t points = 0;  // that agree with it
};

/// Fits a circle, then fits it twice more without points far from it: the edge of a thing in front, a shadow's rim, a
/// neighbour that touches it. Afterwards the points that agree are in front.
/// Thread:  any.   RT: yes.
Outline fit_outline(std::span<PointPx> points, const StrayLimits& limits);

}  // namespace sinew::vision
