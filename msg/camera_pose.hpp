#pragma once
#include "msg/geometry.hpp"

namespace sinew::msg {

/// Where a camera was when it took a picture.
/// Frames:  q takes the camera's axes (optical: x right, y down, z ahead) to those of the robot's odometry (z up, the
///          ground at 0).
struct CameraPose {
  Time stamp;  // of the picture: the middle of its exposure
  Quat q_world_optical;
  Vec3 p_world_m;
};

template <>
struct Description<CameraPose> {
  using M = CameraPose;
  static constexpr std::string_view name = "CameraPose", doc = "Where a camera was when it took a picture.";
  static constexpr auto fields =
      describe(field<&M::stamp>("ns", "of the picture: the middle of its exposure"),
               field<&M::q_world_optical>("1", "from x right, y down, z ahead to the odometry's axes, z up"),
               field<&M::p_world_m>("m", "in the odometry's frame; the ground is at z = 0"));
};

}  // namespace sinew::msg
