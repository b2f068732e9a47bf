#include "motion/posture.hpp"

#include <algorithm>

namespace sinew::motion {

TorsoOffsets torso_offsets(const Figure& figure, const WalkParams& walk, const JointAngles& rest_rad) {
  TorsoOffsets out;
  JointAngles standing = rest_rad;
  out.over_hips_m = -figure.leg(Side::left).leg.hip_m().z;
  const math::Quat lean = math::Quat::from_axis_angle({0, 1, 0}, walk.lean_rad);
  for (const Side side : kSides) {
    const math::Vec3 sole{0, sign(side) * 0.5 * walk.stance_m, -walk.height_m - out.over_hips_m};
    figure.place_sole(side, {lean.conjugate().rotate(sole), lean.conjugate()}, standing);
  }
  kinematics::BodyPose pose(figure.body());
  pose.set(std::span(standing).first(figure.joints()), {{}, lean});
  out.com_m = {pose.centre_of_mass().x, 0, pose.centre_of_mass().z};
  return out;
}

Lean lean_beside(const math::Quat& q_world_torso, const math::Quat& q_planned_torso) {
  constexpr double kMost_rad = 0.5;  // beyond, nothing is to be saved
  const math::Vec3 up = q_world_torso.conjugate().rotate({0, 0, 1});
  const math::Vec3 planned = q_planned_torso.conjugate().rotate({0, 0, 1});
  return {std::clamp(math::atan2(planned.x, planned.z) - math::atan2(up.x, up.z), -kMost_rad, kMost_rad),
          std::clamp(math::atan2(up.y, up.z) - math::atan2(planned.y, planned.z), -kMost_rad, kMost_rad)};
}

}  // namespace sinew::motion
