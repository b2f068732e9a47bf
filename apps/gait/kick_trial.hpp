#pragma once
// Kicks on the pitch.
#include <optional>
#include <string>

#include "apps/gait/rig.hpp"

namespace sinew::gait {

struct KickTrial {
  std::uint64_t seed = 1;
  motion::Side foot = motion::Side::left;
  motion::KickWay way = motion::KickWay::forward;
  bool walking = false;  // within a step
};

struct KickResult {
  bool fell = false;
  bool touched = false;
  double speed_mps = 0;      // of the ball, at its fastest
  double direction_deg = 0;  // away from the wanted direction, left is positive
  double rolls_m = 0;        // how far from where it lay, 3 s after the kick's begin
};

/// A ball lies where the kick expects it, up to 10 mm beside and before that.
/// Errors:  nothing, with `why`.
std::optional<KickResult> run_kick(const GaitSetup& setup, const KickTrial& trial, std::string& why);

}  // namespace sinew::gait
