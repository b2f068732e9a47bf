#pragma once
// A landing pad seen by a camera that looks down, for tests: exact geometry, a coarse anti-aliasing, sensor noise.
#include <cmath>

#include "images.hpp"
#include "vision/pinhole.hpp"

namespace sinew::vision::test {

/// The camera's place over the pad (metres, its image's right and down directions on the ground) and its tilt.
struct CameraPose {
  double height_m = 1, right_m = 0, down_m = 0;
  double tilt_x_rad = 0, tilt_y_rad = 0;  // turns of the view about its x and y axes
};

inline Rgb pad_colour(double x, double y) {
  const double r = std::hypot(x, y), ax = std::fabs(x), ay = std::fabs(y);
  const bool post = std::fabs(ax - 0.045) < 0.011 && ay < 0.085, bar = ax < 0.045 && ay < 0.011;
  if (post || bar || std::fabs(r - 0.155) < 0.011) return {240, 240, 238};
  if (r < 0.30) return {236, 66, 18};
  if (ax < 0.4 && ay < 0.4) return {44, 46, 52};
  const bool light = (int(std::floor(x * 5)) + int(std::floor(y * 5))) % 2 == 0;
  return light ? Rgb{160, 150, 138} : Rgb{128, 122, 112};  // floor
}

class PadScene {
 public:
  PadScene(const CameraPose& pose, std::uint32_t width, std::uint32_t height)
      : pose_(pose), camera_(Pinhole::from_fov(2 * std::atan(0.5 / 0.875), width, height)) {}

  /// A ray of the camera (tilted) as seen with the untilted axes.
  msg::Vec3 untilted(const msg::Vec3& d) const {
    const double ca = std::cos(pose_.tilt_x_rad), sa = std::sin(pose_.tilt_x_rad);
    const msg::Vec3 e{d.x, ca * d.y - sa * d.z, sa * d.y + ca * d.z};
    const double cb = std::cos(pose_.tilt_y_rad), sb = std::sin(pose_.tilt_y_rad);
    return {cb * e.x + sb * e.z, e.y, -sb * e.x + cb * e.z};
  }
  Rgb at(double u, double v) const {
    const msg::Vec3 d = untilted(camera_.direction(u, v));
    const double t = pose_.height_m / d.z;
    return pad_colour(pose_.right_m + t * d.x, pose_.down_m + t * d.y);
  }
  /// Mean of 3 x 3 samples, plus noise.
  Rgb pixel(std::uint32_t x, std::uint32_t y, math::Random& random, double noise, double light) const {
    int r = 0, g = 0, b = 0;
    for (int i = -1; i <= 1; ++i)
      for (int k = -1; k <= 1; ++k) {
        const Rgb c = at(x + i / 3.0, y + k / 3.0);
        r += c.r, g += c.g, b += c.b;
      }
    const auto out = [&](int sum) {
      return std::clamp(int(std::lround(light * sum / 9.0 + noise * random.normal())), 0, 255);
    };
    return {out(r), out(g), out(b)};
  }
  void render(std::uint8_t* yuyv, std::uint32_t width, std::uint32_t height, double noise = 3, double light = 1) const {
    math::Random random(17);
    paint_yuyv(yuyv, width, height,
               [&](std::uint32_t x, std::uint32_t y) { return pixel(x, y, random, noise, light); });
  }
  /// Where the pad's centre is: its direction in the tilted camera, and the distance.
  msg::Vec3 true_direction() const {
    // Inverse of untilted(): the turns are orthogonal, so the transposed ones in the other order.
    msg::Vec3 d{-pose_.right_m, -pose_.down_m, pose_.height_m};
    const double cb = std::cos(pose_.tilt_y_rad), sb = std::sin(pose_.tilt_y_rad);
    d = {cb * d.x - sb * d.z, d.y, sb * d.x + cb * d.z};
    const double ca = std::cos(pose_.tilt_x_rad), sa = std::sin(pose_.tilt_x_rad);
    d = {d.x, ca * d.y + sa * d.z, -sa * d.y + ca * d.z};
    const double n = true_range_m();
    return {d.x / n, d.y / n, d.z / n};
  }
  double true_range_m() const {
    return std::sqrt(pose_.right_m * pose_.right_m + pose_.down_m * pose_.down_m + pose_.height_m * pose_.height_m);
  }
  const Pinhole& camera() const { return camera_; }

 private:
  CameraPose pose_;
  Pinhole camera_;
};

}  // namespace sinew::vision::test
