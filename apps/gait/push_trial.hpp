#pragma once
// Pushes while walking: whether it stays up, and whether a fall was seen in time.
#include <optional>
#include <string>

#include "apps/gait/rig.hpp"

namespace sinew::gait {

struct PushTrial {
  std::uint64_t seed = 1;
  double speed_mps = 0.4;    // change of the body's speed: the impulse is that times its mass
  double direction_rad = 0;  // in which it is pushed, from the torso's x to its left
  double lasts_s = 0.1;
  double forward_mps = 0.2;  // of the walk
  bool react = true;         // to a fall that is seen: joints relaxed, and posed by the motion fall_front and so on
};

struct PushResult {
  bool fell = false;         // something other than its soles touched the ground, or it tilted by 60 degrees
  bool fell_before = false;  // already before the push: it says nothing about it
  bool seen = false;         // the detector told a fall
  double ahead_s = 0;        // so long before the ground was hit; what was taken back does not count
  double hit_after_s = 0;    // so long after the push began
  double impact_nms = 0;     // of all leg and arm joints, the largest change of the rotor's angular momentum at the
                             // joint within 10 ms, in the half second from the blow on
  double gear_nm = 0;        // the largest torque that a rotor's inertia and its motor put on a gear then
};

/// Walks for a while, is pushed once at a random phase, and walks on for 5 s.
/// Errors:  nothing, with `why`.
std::optional<PushResult> run_push(const GaitSetup& setup, const PushTrial& trial, std::string& why);

}  // namespace sinew::gait
