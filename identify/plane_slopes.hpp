#pragma once
// How a pixel that shows a point of a plane moves with the camera's numbers and with the plane.
#include <array>

#include "identify/camera_fit.hpp"

namespace sinew::identify {

/// u and v by the camera's numbers and by small turns and shifts of the plane, in the camera's axes.
struct Slopes {
  std::array<double, kCameraNumbers> camera[2];
  std::array<double, 6> pose[2];
};

/// False: the point is not ahead of the camera. `slopes` may be null.
bool predict(const LensCamera& c, const kinematics::Pose& plane, const PlanePoint& p, LensCamera::Pixel& pixel,
             Slopes* slopes);

/// Turned by the first three numbers and shifted by the others, in the camera's axes.
kinematics::Pose moved(const kinematics::Pose& p, const double* by);

}  // namespace sinew::identify
