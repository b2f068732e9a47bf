#pragma once
// All that a body's motions are made of, as its motion file says it.
#include <map>
#include <string>
#include <vector>

#include "motion/ball_stop.hpp"
#include "motion/fall.hpp"
#include "motion/gaze.hpp"
#include "motion/key_poses.hpp"
#include "motion/kick.hpp"
#include "motion/step_kick.hpp"
#include "motion/walk_params.hpp"

namespace sinew::motion {

struct MotionBook {
  JointAngles rest_rad{};  // of arms and head while walking
  WalkParams walk{};
  FallParams fall{};
  KickParams kick_forward{}, kick_outward{};
  StepKickParams step_kick_forward{}, step_kick_outward{};
  BallStopParams stop{};
  GazeParams gaze{};
  std::map<std::string, std::vector<KeyPose>> poses{};  // "rise_front": its poses, in order

  /// Null: there are none of this name.
  const std::vector<KeyPose>* find(const std::string& name) const {
    const auto found = poses.find(name);
    return found == poses.end() ? nullptr : &found->second;
  }
};

}  // namespace sinew::motion
