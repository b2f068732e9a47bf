#pragma once
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

}  // namespace sinew::vision
