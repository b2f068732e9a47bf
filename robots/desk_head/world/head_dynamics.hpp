#pragma once
#include <array>

#include "math/linear.hpp"
#include "robots/desk_head/world/head_body.hpp"

namespace sinew::plant {

/// Motion of a frame, in its own axes. `a` is what an accelerometer in its origin would feel.
struct LinkMotion {
  math::Vec3 w_radps, dw_radps2, a_mps2;
};

struct HeadMotion {
  LinkMotion yoke, head;
  std::array<double, kHeadJoints> accel_radps2{};
};

/// Accelerations of the two joints on a base with any motion, under the given joint torques. `armature`: of each motor,
/// seen at its joint.
/// Source:  recursive Newton-Euler equations: J. Luh, M. Walker, R. Paul, On-line computational scheme for mechanical
///          manipulators, J. Dyn. Sys. 102 (1980); torques of unit accelerations give the mass matrix.
HeadMotion head_motion(const LinkMotion& base, const std::array<double, kHeadJoints>& q_rad,
                       const std::array<double, kHeadJoints>& v_radps, const std::array<double, kHeadJoints>& torque_nm,
                       const std::array<double, kHeadJoints>& armature_kgm2);

}  // namespace sinew::plant
