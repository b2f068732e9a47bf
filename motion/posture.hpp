#pragma once
// The torso over the feet: what walking, standing and kicking have in common.
#include "motion/figure.hpp"
#include "motion/planar.hpp"
#include "motion/servo_lead.hpp"
#include "motion/walk_params.hpp"

namespace sinew::motion {

/// Where the centre of mass is from the torso's origin while the body stands, axes of the ground; and how far that
/// origin is over the hips.
struct TorsoOffsets {
  math::Vec3 com_m;
  double over_hips_m = 0;
};
TorsoOffsets torso_offsets(const Figure& figure, const WalkParams& walk, const JointAngles& rest_rad);

/// How far the torso leans beside the plan: forward and to the right are positive, as rotations about y and x.
struct Lean {
  double pitch_rad = 0, roll_rad = 0;
};
Lean lean_beside(const math::Quat& q_world_torso, const math::Quat& q_planned_torso);

}  // namespace sinew::motion
