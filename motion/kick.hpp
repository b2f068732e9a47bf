#pragma once
// A kick from a stand: the weight goes to one foot, the other one strikes.
#include "motion/kick_way.hpp"
#include "motion/one_foot.hpp"
#include "motion/param.hpp"

namespace sinew::motion {

/// Of one way to kick.
struct KickParams {
  double shift_s = 0.5, lift_s = 0.3, still_s = 0.1, strike_s = 0.1, follow_s = 0.1, return_s = 0.35, lower_s = 0.25;
  double com_inside_m = 0.004, com_forward_m = 0;
  double taller_m = 0, less_lean_rad = 0;
  double lift_m = 0.03, strike_lift_m = 0.03;
  double back_m = 0.07, strike_m = 0.1;
  double back_tip_rad = 0, strike_tip_rad = 0;
  double lean_back_rad = 0;
  double gyro_pitch_s = 0.05, gyro_roll_s = 0.05, tilt_pitch = 0.2, tilt_roll = 0.2;
  double arm_swing_rad = 0.6;
};

inline constexpr Param<KickParams> kKickParams[] = {
    {"shift_s", &KickParams::shift_s, "s", 0.1, 2, "for the weight to go to one foot, and back at the end"},
    {"lift_s", &KickParams::lift_s, "s", 0.05, 2, "for the foot to go up and back"},
    {"still_s", &KickParams::still_s, "s", 0, 1, "it waits there"},
    {"strike_s", &KickParams::strike_s, "s", 0.02, 1, "from there to the furthest point"},
    {"follow_s", &KickParams::follow_s, "s", 0, 1, "it stays there"},
    {"return_s", &KickParams::return_s, "s", 0.05, 2, "from there above its old place"},
    {"lower_s", &KickParams::lower_s, "s", 0.05, 2, "down to the ground"},
    {"com_inside_m", &KickParams::com_inside_m, "m", -0.03, 0.04,
     "the centre of mass inside of the carrying sole's middle"},
    {"com_forward_m", &KickParams::com_forward_m, "m", -0.04, 0.04, "before its middle"},
    {"taller_m", &KickParams::taller_m, "m", -0.03, 0.03, "how much higher it stands than for the walk"},
    {"less_lean_rad", &KickParams::less_lean_rad, "rad", -0.3, 0.3, "how much less its torso leans forward"},
    {"lift_m", &KickParams::lift_m, "m", 0.005, 0.1, "of the foot, when it is back"},
    {"strike_lift_m", &KickParams::strike_lift_m, "m", 0.005, 0.12, "when it is furthest"},
    {"back_m", &KickParams::back_m, "m", -0.05, 0.2, "how far it goes away from the ball before it strikes"},
    {"strike_m", &KickParams::strike_m, "m", 0.02, 0.2, "how far toward the ball it strikes"},
    {"back_tip_rad", &KickParams::back_tip_rad, "rad", 0, 1,
     "the sole's edge toward the ball goes down before the strike"},
    {"strike_tip_rad", &KickParams::strike_tip_rad, "rad", 0, 1,
     "and up at its end: a sole that stays level would need twice the speed at the ankle"},
    {"lean_back_rad", &KickParams::lean_back_rad, "rad", -0.5, 0.5, "of the torso away from the ball"},
    {"gyro_pitch_s", &KickParams::gyro_pitch_s, "s", 0, 0.3, "ankle pitch for each rad/s of the torso"},
    {"gyro_roll_s", &KickParams::gyro_roll_s, "s", 0, 0.3, "ankle roll for each rad/s of the torso"},
    {"tilt_pitch", &KickParams::tilt_pitch, "1", -0.5, 1, "ankle pitch for each rad of the torso's tilt"},
    {"tilt_roll", &KickParams::tilt_roll, "1", -0.5, 1, "ankle roll for each rad of the torso's tilt"},
    {"arm_swing_rad", &KickParams::arm_swing_rad, "rad", -2, 2, "the arms swing against the strike"},
};

/// Lengths are along the strike: forward, or to the foot's own side. Begins and ends in the walk's standing pose.
/// Thread:  owner.   RT: yes, after the constructor.
class Kick {
 public:
  KickParams forward, outward;

  /// Stance and servos as the walk's.
  Kick(const Figure& figure, const WalkParams& walk, std::span<const double> rest_rad)
      : stand_(figure, walk, rest_rad) {}

  void start(Side foot, KickWay way);
  /// `q_world_torso`: attitude; the rate without bias, torso axes.
  void step(const math::Quat& q_world_torso, const math::Vec3& rate_radps, double dt_s, std::span<double> targets_rad);
  bool active() const { return active_; }
  double time_s() const { return time_s_; }
  double lasts_s() const { return duration_s(way()); }
  /// State (kept_numbers.hpp): all that a step leaves for later ones.
  template <class Visit>
  void each_part(Visit&& visit) {
    visit(stand_, foot_, way_, time_s_, active_);
  }

 private:
  const KickParams& params() const { return way_ == KickWay::forward ? forward : outward; }
  std::array<FootPlace, 8> way() const;

  OneFoot stand_;
  Side foot_ = Side::left;
  KickWay way_ = KickWay::forward;
  double time_s_ = 0;
  bool active_ = false;
};

}  // namespace sinew::motion
