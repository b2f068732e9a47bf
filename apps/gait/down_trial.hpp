#pragma once
// Getting down from a stand, so that the servos may be switched off.
#include <optional>
#include <string>

#include "apps/gait/rig.hpp"

namespace sinew::gait {

inline constexpr const char* kGetDown = "get_down";

struct DownResult {
  bool lies = false;     // on its front, two seconds after the servos lost their torque
  bool gently = false;   // and it turned slower than 2 rad/s when it tilted by 60 degrees: it did not topple
  double time_s = 0;     // from standing until it tilted by 60 degrees
  double blow_mps2 = 0;  // the largest acceleration that the IMU measured
};

/// Stands for a second, gets down by the motion "get_down", then has no torque.
/// Errors:  nothing, with `why`.
std::optional<DownResult> run_down(const GaitSetup& setup, std::uint64_t seed, std::string& why);

}  // namespace sinew::gait
