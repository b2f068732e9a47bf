#pragma once
// From a plane to a picture.
#include <optional>

#include "identify/camera_fit.hpp"

namespace sinew::identify {

/// Takes (x, y, 1) on the plane to (u, v, 1) times something. Nothing: fewer than 4 points, or all in a line.
/// Source:  R. Hartley and A. Zisserman, Multiple View Geometry (2004), algorithm 4.2: normalised direct linear
///          transformation.
std::optional<math::Mat3> homography(const PlaneView& view);

/// The camera of these homographies, in closed form: first all of fx, fy, cx, cy (skew 0), and where that
/// gives no camera whose centre is in the picture, one with square pixels around its middle. Nothing: neither.
/// Source:  Z. Zhang (camera_fit.hpp), section 3.1.
std::optional<LensCamera> closed_form_camera(std::span<const math::Mat3> all, double width_px, double height_px);

/// The plane's pose in the camera's frame, of a camera without distortion.
std::optional<kinematics::Pose> pose_of(const math::Mat3& homography, const LensCamera& camera);

}  // namespace sinew::identify
