#pragma once
// Poses of a body that stands on both feet and looks at something on the ground before it: what a calibration of its
// joints and of its camera looks at (docs/calibrate.md).
#include <vector>

#include "motion/figure.hpp"

namespace sinew::motion {

struct StandPosesOptions {
  std::size_t poses = 40;
  double height_m = 0.2, stance_m = 0.105;  // of the hips over the soles; between the middles of the soles
  double ahead_m = 0.5, aside_m = 0;        // where it looks, on the ground, from between its feet
  double around_m = 0.1;                    // up to this far beside it, both ways
  double tilt_rad = 0.16, turn_rad = 0.3;   // of the torso, both ways
  double shift_m = 0.018, lower_m = 0.05;
  std::uint64_t seed = 1;
};

/// The feet stay where they are, flat on the ground and parallel; the torso is shifted, lowered, tilted and turned
/// another way in each pose with its centre of mass between the feet; arms hang. Fewer than asked for, where most poses
/// are out of reach.
/// Thread:  any.   RT: configure only.
std::vector<JointAngles> stand_poses(const Figure& figure, const StandPosesOptions& options);

}  // namespace sinew::motion
