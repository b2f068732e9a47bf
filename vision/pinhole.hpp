#pragma once
#include "math/elementary.hpp"
#include "msg/geometry.hpp"

namespace sinew::vision {

/// A camera without distortion. Pixel centres have whole coordinates: the middle of an image is (width - 1) / 2.
/// Frames:  camera_optical: z forward, x right, y down.
struct Pinhole {
  double fx_px = 0, fy_px = 0, cx_px = 0, cy_px = 0;

  /// Square pixels, the axis in the middle of the image.
  static Pinhole from_fov(double fov_y_rad, double width_px, double height_px) {
    const double f = 0.5 * height_px / math::tan(0.5 * fov_y_rad);
    return {f, f, 0.5 * (width_px - 1), 0.5 * (height_px - 1)};
  }
  /// This camera, with the numbers that `given` has (0: not given) in place of its own.
  Pinhole or_given(const Pinhole& given) const {
    const auto either = [](double own, double other) { return other > 0 ? other : own; };
    return {either(fx_px, given.fx_px), either(fy_px, given.fy_px), either(cx_px, given.cx_px),
            either(cy_px, given.cy_px)};
  }
  /// Unit vector to the thing that a pixel shows.
  msg::Vec3 direction(double u_px, double v_px) const {
    const double x = (u_px - cx_px) / fx_px, y = (v_px - cy_px) / fy_px;
    const double n = math::sqrt(x * x + y * y + 1);
    return {x / n, y / n, 1 / n};
  }
};

}  // namespace sinew::vision
