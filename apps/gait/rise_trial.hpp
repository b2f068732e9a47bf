#pragma once
// Rising from the ground on the pitch.
#include <optional>
#include <string>

#include "apps/gait/rig.hpp"

namespace sinew::gait {

struct RiseResult {
  bool stood = false;     // upright within 5 s, and still so 1 s after
  double time_s = 0;      // from lying until it stood upright to stay
  double up = 0;          // at the end: z of the torso's z,
  double height_m = 0;    // its height
  double load = 0;        // and the share of the weight on the soles
  double shortfall = 0;   // mean over the motion of how far it was from standing, 0 to 1: what a search lessens
  double from_front = 1;  // the least that its front was away from facing the ground, 0 to 1
};

/// Lies there in its standing pose, half a second later rises by the motion of this name, then stands.
/// Errors:  nothing, with `why`.
std::optional<RiseResult> run_rise(const GaitSetup& setup, const std::string& motion, std::uint64_t seed,
                                   std::string& why);

}  // namespace sinew::gait
