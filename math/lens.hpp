#pragma once
// What a lens does to a picture beside the pinhole: Brown's radial and tangential terms, on coordinates divided by the
// depth. The one formula for all that see, draw or calibrate through a lens.
// Thread:  any.   RT: yes.
// Source:  D. C. Brown, Close-range camera calibration, Photogrammetric Engineering 37 (1971); order and signs as
//          "plumb_bob" of OpenCV and ROS.
#include "math/matrix.hpp"

namespace sinew::math {

struct LensDistortion {
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;

  struct Xy {
    double x = 0, y = 0;
  };
  constexpr bool none() const { return k1 == 0 && k2 == 0 && p1 == 0 && p2 == 0 && k3 == 0; }
  /// Where the lens puts what a pinhole would have at (x, y).
  constexpr Xy distorted(double x, double y) const {
    const double r2 = x * x + y * y, radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
    return {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x), y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
  }
  /// Rows x, y of distorted(); columns x, y.
  constexpr Mat<2, 2> derivative(double x, double y) const {
    const double r2 = x * x + y * y, radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
    const double slope = 2 * (k1 + r2 * (2 * k2 + 3 * r2 * k3));  // of `radial` with r2, times 2
    const double mixed = x * y * slope + 2 * p1 * x + 2 * p2 * y;
    return {radial + x * x * slope + 2 * p1 * y + 6 * p2 * x, mixed, mixed,
            radial + y * y * slope + 6 * p1 * y + 2 * p2 * x};
  }
  /// The inverse of distorted(), by Newton's method. False, and (x, y) as they are: no point of the branch around
  /// the axis is there, as beyond the edge of a strong barrel.
  bool straighten(Xy& p) const {
    if (none()) return true;
    Xy at = p;
    for (int i = 0; i < 30; ++i) {
      const Xy there = distorted(at.x, at.y);
      const Mat<2, 2> d = derivative(at.x, at.y);
      const double det = d(0, 0) * d(1, 1) - d(0, 1) * d(1, 0), ex = p.x - there.x, ey = p.y - there.y;
      if (!(det > 1e-3)) return false;
      at.x += (d(1, 1) * ex - d(0, 1) * ey) / det;
      at.y += (d(0, 0) * ey - d(1, 0) * ex) / det;
      if (!is_finite(at.x) || !is_finite(at.y)) return false;
      if (ex * ex + ey * ey < 1e-24) {
        p = at;
        return true;
      }
    }
    return false;
  }
  friend constexpr bool operator==(const LensDistortion&, const LensDistortion&) = default;
};

}  // namespace sinew::math
