#pragma once
// A camera's numbers from views of something flat whose points are known: a printed board, the lines of a field.
//
//   std::vector<PlaneView> views = ...;            // of each picture: places on the plane, and the pixels that show
//   them const CameraFit fit = fit_camera(views, {.width_px = 640, .height_px = 480}); if (fit.problem.empty())
//   fit.camera.fx_px;     // +- fit.estimates[0].half_width, 95 %
//
// Frames:  a plane has x and y, its z is 0; a camera's frame is optical: x right, y down, z ahead. Pixel (0, 0) has its
//          centre at 0, 0.
// Thread:  any.   RT: no, it allocates.
#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "identify/dense.hpp"
#include "kinematics/body.hpp"
#include "math/lens.hpp"

namespace sinew::identify {

struct PlanePoint {
  double x_m = 0, y_m = 0;  // on the plane
  double u_px = 0, v_px = 0;
};
using PlaneView = std::vector<PlanePoint>;  // of one picture; at least 4 points, not all in a line

struct LensCamera {
  double fx_px = 0, fy_px = 0, cx_px = 0, cy_px = 0;
  math::LensDistortion lens{};

  struct Pixel {
    double u_px = 0, v_px = 0;
  };
  /// Of a point ahead of the camera, z > 0.
  Pixel pixel(const math::Vec3& p) const {
    const auto d = lens.distorted(p.x / p.z, p.y / p.z);
    return {cx_px + fx_px * d.x, cy_px + fy_px * d.y};
  }
};

enum class CameraNumber : std::uint8_t { fx, fy, cx, cy, k1, k2, p1, p2 };
inline constexpr std::size_t kCameraNumbers = 8;
struct CameraNumberText {
  std::string_view name, unit, doc;
};
const std::array<CameraNumberText, kCameraNumbers>& camera_numbers();

struct CameraEstimate {
  double value = 0;
  double half_width = 0;  // of the 95 % interval; infinite: the views do not show it
  bool shown = true;      // false: a coefficient of the lens is held at 0, and others are what the views leave open
};

struct CameraFitOptions {
  double width_px = 640, height_px = 480;
  std::size_t held_out_each = 5;  // each so many-th view is predicted by a fit of the others; 0: none
  double open_px = 4;  // a coefficient of the lens that leaves more than this open at the outermost point, and may be
                       // 0, is held there
};

struct CameraFit {
  std::string problem;  // empty: all that follows is there
  LensCamera camera;
  std::array<CameraEstimate, kCameraNumbers> estimates{};
  std::vector<kinematics::Pose> plane;  // of each view, in the camera's frame
  std::vector<double> view_rms_px;      // of each view: of a point's distance from its pixel
  std::size_t views = 0, points = 0;
  double rms_px = 0;           // the same over all of them
  double sigma_px = 0;         // of a coordinate's error
  double held_out_rms_px = 0;  // of views that were not fitted, with a pose of their own; NaN: none were held out
  double tilt_deg = 0;         // the largest angle between two planes as the camera saw them
  double reach = 0;            // the outermost point's distance from the axis / that of the picture's farthest corner
  std::vector<std::string> unknown;  // what the views do not show, in words
};

/// The start is a closed form (Zhang's); then all views are fitted together by Levenberg-Marquardt, errors beyond 2.5
/// sigmas counting linearly. The intervals are the covariance's of the last step; they allow for
/// errors that the points of a view have in common.
/// Errors:  `problem`: fewer than 3 views, a view with too few points, numbers that are not finite, or no camera
///          that could have seen this.
/// Source:  Z. Zhang, A flexible new technique for camera calibration, IEEE TPAMI 22 (2000).
CameraFit fit_camera(std::span<const PlaneView> views, const CameraFitOptions& options = {});

/// Where a known camera sees the plane: its pose in the camera's frame. Nothing: the view has too few points, or is not
/// of a plane ahead.
std::optional<kinematics::Pose> plane_pose(const LensCamera& camera, const PlaneView& view);

}  // namespace sinew::identify
