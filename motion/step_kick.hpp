#pragma once
// A kick within a step of the walk: the swinging foot strikes on its way.
#include "motion/param.hpp"

namespace sinew::motion {

/// Of one way to kick. Lengths are along the strike: forward, or to the foot's own side.
struct StepKickParams {
  double stretch = 1.4;
  double back_m = 0.04, strike_m = 0.1, lift_m = 0.01, tip_rad = 0.4, lean_back_rad = 0, aim_rad = 0;
  double back_at = 0.35, hit_at = 0.65, hold = 0.1;
};

inline constexpr Param<StepKickParams> kStepKickParams[] = {
    {"stretch", &StepKickParams::stretch, "1", 1, 2.5, "the step lasts longer by this factor"},
    {"back_m", &StepKickParams::back_m, "m", -0.02, 0.15, "how far it goes away from the ball before it strikes"},
    {"strike_m", &StepKickParams::strike_m, "m", 0.02, 0.25, "how far beyond its way it strikes"},
    {"lift_m", &StepKickParams::lift_m, "m", 0, 0.06, "how much higher it goes"},
    {"tip_rad", &StepKickParams::tip_rad, "rad", 0, 1, "the sole's edge toward the ball goes up with the strike"},
    {"lean_back_rad", &StepKickParams::lean_back_rad, "rad", -0.5, 0.5,
     "the torso leans away from the ball with the strike"},
    {"aim_rad", &StepKickParams::aim_rad, "rad", -0.5, 0.5,
     "strike and sole turn by so much, those of the left foot clockwise seen from above"},
    {"back_at", &StepKickParams::back_at, "1", 0.1, 0.6, "part of the step at which it is back"},
    {"hit_at", &StepKickParams::hit_at, "1", 0.3, 0.95, "part of the step at which it is to be furthest"},
    {"hold", &StepKickParams::hold, "1", 0, 0.4, "part of the step for which it is held there"},
};

}  // namespace sinew::motion
