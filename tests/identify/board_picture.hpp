#pragma once
// Pictures of a printed chessboard, as a camera with a secret lens would take them.
#include <algorithm>
#include <cstdint>
#include <vector>

#include "identify/camera_fit.hpp"
#include "math/random.hpp"
#include "vision/board_finder.hpp"

namespace sinew::identify::test {

struct PictureOptions {
  std::uint32_t width = 640, height = 480;
  double noise = 2;      // grey levels, sigma
  double blur_px = 0.7;  // half the width of the box that a pixel averages
  double dark = 40, bright = 210;
};

/// A board of this size with squares of `square_m`; its first inner corner is 0, 0 on the plane, and the square beyond
/// it (towards positive x and y) is dark.
class BoardPictures {
 public:
  BoardPictures(const identify::LensCamera& camera, const vision::BoardSize& board, double square_m,
                const PictureOptions& options = {})
      : camera_(camera), board_(board), square_m_(square_m), o_(options), pixels_(std::size_t{o_.width} * o_.height) {
    for (std::uint32_t v = 0; v < o_.height; ++v)
      for (std::uint32_t u = 0; u < o_.width; ++u)
        for (int k = 0; k < kSamples * kSamples; ++k) {
          const auto part = [&](int i) { return o_.blur_px * (2 * (i + 0.5) / kSamples - 1); };
          math::LensDistortion::Xy at{(u + part(k % kSamples) - camera.cx_px) / camera.fx_px,
                                      (v + part(k / kSamples) - camera.cy_px) / camera.fy_px};
          if (!camera.lens.straighten(at)) at = {1e3, 1e3};
          ray_.push_back({static_cast<float>(at.x), static_cast<float>(at.y)});
        }
  }

  /// The board where `plane` is in the camera's frame.
  vision::ImageView draw(const kinematics::Pose& plane, math::Random& random) {
    const math::Vec3 x = plane.q.rotate({1, 0, 0}), y = plane.q.rotate({0, 1, 0}), n = cross(x, y);
    const double away = dot(n, plane.p_m);
    const double most_x = (board_.columns + 0.8) * square_m_, most_y = (board_.rows + 0.8) * square_m_;
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
      double sum = 0;
      for (int k = 0; k < kSamples * kSamples; ++k) {
        const auto& r = ray_[i * kSamples * kSamples + static_cast<std::size_t>(k)];
        const math::Vec3 ray{r[0], r[1], 1};
        const double scale = away / dot(n, ray);
        const math::Vec3 at = ray * scale - plane.p_m;
        const double px = dot(at, x), py = dot(at, y);
        double grey = 110 + 30 * ray.x;
        if (scale > 0 && px > -1.8 * square_m_ && px < most_x && py > -1.8 * square_m_ && py < most_y) {
          const double i_square = px / square_m_ + 1, j_square = py / square_m_ + 1;  // of all squares
          const bool on = i_square > 0 && j_square > 0 && i_square < board_.columns + 1 && j_square < board_.rows + 1;
          const bool dark = on && (static_cast<int>(i_square) + static_cast<int>(j_square)) % 2 == 0;
          grey = dark ? o_.dark : o_.bright;
        }
        sum += grey;
      }
      const double value = sum / (kSamples * kSamples) + (o_.noise > 0 ? random.normal(0, o_.noise) : 0);
      pixels_[i] = static_cast<std::uint8_t>(std::clamp(value + 0.5, 0.0, 255.0));
    }
    return {pixels_.data(), o_.width, o_.height, o_.width, msg::PixelFormat::mono8};
  }

  /// Where its inner corners truly are, row after row.
  std::vector<vision::BoardCorner> corners(const kinematics::Pose& plane) const {
    std::vector<vision::BoardCorner> out;
    for (std::uint32_t j = 0; j < board_.rows; ++j)
      for (std::uint32_t i = 0; i < board_.columns; ++i) {
        const auto at = camera_.pixel(plane.of({i * square_m_, j * square_m_, 0}));
        out.push_back({at.u_px, at.v_px});
      }
    return out;
  }
  /// Whole in the picture, by so many pixels.
  bool holds(const kinematics::Pose& plane, double margin_px) const {
    for (const double x : {-1.0, static_cast<double>(board_.columns)})
      for (const double y : {-1.0, static_cast<double>(board_.rows)}) {
        const math::Vec3 p = plane.of({x * square_m_, y * square_m_, 0});
        if (p.z < 0.1) return false;
        const auto at = camera_.pixel(p);
        if (!(at.u_px > margin_px) || !(at.v_px > margin_px) || !(at.u_px < o_.width - margin_px) ||
            !(at.v_px < o_.height - margin_px))
          return false;
      }
    return true;
  }

 private:
  static constexpr int kSamples = 3;
  identify::LensCamera camera_;
  vision::BoardSize board_;
  double square_m_;
  PictureOptions o_;
  std::vector<std::uint8_t> pixels_;
  std::vector<std::array<float, 2>> ray_;
};

/// A camera as webcams and robots have them.
inline identify::LensCamera secret_camera(math::Random& r, double width_px, double height_px) {
  const double f = r.uniform(0.62, 1.1) * width_px;
  return {f,
          f * r.uniform(0.98, 1.02),
          0.5 * (width_px - 1) + r.normal(0, 0.02 * width_px),
          0.5 * (height_px - 1) + r.normal(0, 0.02 * width_px),
          {r.uniform(-0.3, 0.1), r.uniform(-0.05, 0.1), r.normal(0, 0.001), r.normal(0, 0.001), 0}};
}

/// A board held somewhere before it, tilted by up to `tilt_rad` about both axes, whole in the picture.
inline kinematics::Pose held(const BoardPictures& pictures, const identify::LensCamera& c, const vision::BoardSize& b,
                             double square_m, double width_px, double height_px, double tilt_rad, math::Random& r) {
  while (true) {
    kinematics::Pose p;
    p.q = math::Quat::exp({r.uniform(-tilt_rad, tilt_rad), r.uniform(-tilt_rad, tilt_rad), r.uniform(-0.5, 0.5)});
    const double wide = (b.columns + 2) * square_m, z = r.uniform(1.1, 2.6) * wide * c.fx_px / width_px;
    const math::Vec3 middle{z * (r.uniform(0.05, 0.95) * width_px - c.cx_px) / c.fx_px,
                            z * (r.uniform(0.05, 0.95) * height_px - c.cy_px) / c.fy_px, z};
    p.p_m = middle - p.q.rotate({(b.columns - 1) * 0.5 * square_m, (b.rows - 1) * 0.5 * square_m, 0});
    if (pictures.holds(p, 3)) return p;
  }
}

}  // namespace sinew::identify::test
