#pragma once
// Stops a ball that rolls towards the robot: one foot is put aside, so that the feet are a wide wall without a gap that
// a ball gets through. A ball that comes to rest at the feet has lost its speed in the foot, and its spin on the
// ground.
#include "motion/one_foot.hpp"
#include "motion/param.hpp"

namespace sinew::motion {

struct BallStopParams {
  double shift_s = 0.5;
  double out_s = 0.35, down_s = 0.25, settle_s = 0.8, hold_s = 2;
  double aside_m = 0.09, lift_m = 0.025, back_m = 0.03, torso_down_m = 0.01, over = 0.5;
  double com_inside_m = 0.004, com_forward_m = 0, taller_m = 0, less_lean_rad = 0;
  double gyro_pitch_s = 0.05, gyro_roll_s = 0.05, tilt_pitch = 0.2, tilt_roll = 0.2;
};

inline constexpr Param<BallStopParams> kBallStopParams[] = {
    {"shift_s", &BallStopParams::shift_s, "s", 0.1, 2, "for the weight to go to one foot, and back at the end"},
    {"out_s", &BallStopParams::out_s, "s", 0.05, 2, "for the foot to go aside, once the other one carries"},
    {"down_s", &BallStopParams::down_s, "s", 0.05, 2, "down to the ground"},
    {"settle_s", &BallStopParams::settle_s, "s", 0.1, 2, "for the weight to go between the feet, and back at the end"},
    {"hold_s", &BallStopParams::hold_s, "s", 0, 20, "it waits there for the ball"},
    {"aside_m", &BallStopParams::aside_m, "m", 0, 0.15,
     "how far aside; a ball gets through feet that are further apart than its diameter and a sole's width"},
    {"lift_m", &BallStopParams::lift_m, "m", 0.005, 0.1, "of the foot on its way"},
    {"back_m", &BallStopParams::back_m, "m", 0, 0.1,
     "how far it goes back before it returns: the ball lies at its toes"},
    {"torso_down_m", &BallStopParams::torso_down_m, "m", 0, 0.06, "of the torso while it waits"},
    {"over", &BallStopParams::over, "1", 0, 1, "how much of the weight is on the other foot then; 0: as much on both"},
    {"com_inside_m", &BallStopParams::com_inside_m, "m", -0.03, 0.04,
     "the centre of mass inside of the carrying sole's middle"},
    {"com_forward_m", &BallStopParams::com_forward_m, "m", -0.04, 0.04, "before its middle"},
    {"taller_m", &BallStopParams::taller_m, "m", -0.03, 0.03, "how much higher it stands than for the walk"},
    {"less_lean_rad", &BallStopParams::less_lean_rad, "rad", -0.3, 0.3, "how much less its torso leans forward"},
    {"gyro_pitch_s", &BallStopParams::gyro_pitch_s, "s", 0, 0.3, "ankle pitch for each rad/s of the torso"},
    {"gyro_roll_s", &BallStopParams::gyro_roll_s, "s", 0, 0.3, "ankle roll for each rad/s of the torso"},
    {"tilt_pitch", &BallStopParams::tilt_pitch, "1", -0.5, 1, "ankle pitch for each rad of the torso's tilt"},
    {"tilt_roll", &BallStopParams::tilt_roll, "1", -0.5, 1, "ankle roll for each rad of the torso's tilt"},
};

/// Begins and ends in the walk's standing pose; balances on one foot as a kick does.
/// Thread:  owner.   RT: yes, after the constructor.
class BallStop {
 public:
  BallStopParams params;

  /// Stance and servos as the walk's.
  BallStop(const Figure& figure, const WalkParams& walk, std::span<const double> rest_rad)
      : stand_(figure, walk, rest_rad) {}

  void start(Side foot);
  /// `q_world_torso`: attitude; the rate without bias, torso axes.
  void step(const math::Quat& q_world_torso, const math::Vec3& rate_radps, double dt_s, std::span<double> targets_rad);
  bool active() const { return active_; }
  double lasts_s() const { return duration_s(way()); }
  /// From start() until it waits for the ball.
  double ready_s() const { return params.shift_s + params.out_s + params.down_s + params.settle_s; }
  /// State (kept_numbers.hpp): all that a step leaves for later ones.
  template <class Visit>
  void each_part(Visit&& visit) {
    visit(stand_, foot_, time_s_, active_);
  }

 private:
  std::array<FootPlace, 10> way() const;

  OneFoot stand_;
  Side foot_ = Side::left;
  double time_s_ = 0;
  bool active_ = false;
};

}  // namespace sinew::motion
