#pragma once
// Balls that roll towards the robot.
#include <optional>
#include <string>

#include "apps/gait/rig.hpp"

namespace sinew::gait {

struct StopTrial {
  std::uint64_t seed = 1;
  motion::Side foot = motion::Side::left;
  double speed_mps = 0.8;  // of the ball when it comes to the feet
  double aside_m = 0;      // of the ball's line from the middle of the robot as it stood before, towards the foot
  bool stops = true;       // false: it stands, and the ball comes all the same
};

struct StopResult {
  bool fell = false;
  bool touched = false;
  double touch_mps = 0;  // speed of the ball when it touched the robot
  double speed_mps = 0;  // at the end, when the robot stands on both feet again
  double away_m = 0;     // then, from the middle of the torso over the ground
  bool stopped() const { return touched && !fell && speed_mps < 0.1 && away_m < 0.3; }
};

/// The ball comes towards the robot, its line up to 20 mm beside `aside_m` and up to 2 degrees turned.
/// Errors:  nothing, with `why`.
std::optional<StopResult> run_stop(const GaitSetup& setup, const StopTrial& trial, std::string& why);

}  // namespace sinew::gait
