#pragma once
// Rising from the ground on the pitch.
#include <optional>
#include <string>

#include "apps/gait/rig.hpp"
#include "motion/fall.hpp"

namespace sinew::gait {

struct RiseResult {
  bool stood = false;  // upright in time, and still so at the end
  double time_s = 0;   // from lying until it stood upright to stay
  int motions = 0;     // begun: from a side it is turned onto its front first
};

/// Within this it has to stand; it is watched for 1.5 s more.
constexpr double most_rise_s(motion::FallWay lies_on) {
  return lies_on == motion::FallWay::front || lies_on == motion::FallWay::back ? 5 : 8;
}

/// Lies there in about its standing pose, half a second later rises as kid::Mover does, then stands.
/// Errors:  nothing, with `why`.
std::optional<RiseResult> run_rise(const GaitSetup& setup, motion::FallWay lies_on, std::uint64_t seed,
                                   std::string& why);

/// How near one motion brings a body to standing: what a search lessens.
struct MotionResult {
  bool stood = false;     // upright within 5 s, and still so at the end
  double shortfall = 0;   // mean over the motion of how far it was from standing, 0 to 1
  double from_front = 1;  // the least that its front was away from facing the ground, 0 to 1
};

/// From its back where the motion's name has "back" in it, else from its front.
/// Errors:  nothing, with `why`.
std::optional<MotionResult> run_motion(const GaitSetup& setup, const std::string& motion, std::uint64_t seed,
                                       std::string& why);

/// How a body comes to lie by one motion.
struct TurnResult {
  bool lay = false;  // before the motion as it was wanted: it may roll off its side by itself
  math::Vec3 up;     // in torso axes, half a second after the motion
  double lasts_s = 0;
};

/// Errors:  nothing, with `why`.
std::optional<TurnResult> run_turn(const GaitSetup& setup, const std::string& motion, motion::FallWay lies_on,
                                   std::uint64_t seed, std::string& why);

}  // namespace sinew::gait
