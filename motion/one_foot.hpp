#pragma once
// Standing on one foot while the other one does something: what a kick from a stand and the stop of a ball share.
#include "motion/figure.hpp"
#include "motion/planar.hpp"
#include "motion/servo_lead.hpp"
#include "motion/walk_params.hpp"

namespace sinew::motion {

/// Where the other foot is, in the axes of the foot that carries.
struct FreeFoot {
  double over = 0;           // 0: the weight is on both feet, 1: on the one that carries
  Vec2 from_place_m;         // beside the place where it stands
  double up_m = 0;           // of its sole's middle
  double pitch_rad = 0;      // toes down
  double roll_rad = 0;       // outer edge up
  double lean_back_rad = 0;  // of the torso
  double lean_away_rad = 0;  // of the torso, to the side of the foot that carries
  double torso_down_m = 0;   // lower than it stands
  double tall = 0;           // 0: as the walk stands, 1: as the balance says
  double arms_rad = 0;       // the arm of its side goes back by so much, the other one ahead
};

struct OneFootBalance {
  Vec2 com_m;  // where the centre of mass is above the sole that carries; y: towards the other foot
  double gyro_pitch_s = 0, gyro_roll_s = 0, tilt_pitch = 0, tilt_roll = 0;
  double taller_m = 0, less_lean_rad = 0;  // than the walk stands
};

/// Of a motion's parameters with these names.
template <class Params>
OneFootBalance balance_of(const Params& p) {
  return {{p.com_forward_m, p.com_inside_m},
          p.gyro_pitch_s,
          p.gyro_roll_s,
          p.tilt_pitch,
          p.tilt_roll,
          p.taller_m,
          p.less_lean_rad};
}

/// Stance and servos as the walk's. Thread:  owner.   RT: yes, after the constructor.
class OneFoot {
 public:
  OneFoot(const Figure& figure, const WalkParams& walk, std::span<const double> rest_rad);

  void start();
  /// `free`: the foot that does not carry. `q_world_torso`: attitude; the rate without bias, torso axes.
  void step(Side free, const FreeFoot& at, const OneFootBalance& balance, const math::Quat& q_world_torso,
            const math::Vec3& rate_radps, double dt_s, std::span<double> targets_rad);
  /// State (kept_numbers.hpp).
  template <class Visit>
  void each_part(Visit&& visit) {
    visit(lead_, rate_);
  }

 private:
  const Figure* figure_;
  ServoLead lead_;
  WalkParams walk_;
  JointAngles rest_rad_{};
  math::Vec3 rate_;
};

/// A way of the free foot through places, each reached in its time from the one before. Between two places it begins
/// and ends with speed 0, unless the way there is `sharp`.
struct FootPlace {
  double lasts_s = 0;
  FreeFoot foot;
  bool sharp = false;
};
FreeFoot along_way(std::span<const FootPlace> way, double time_s);
double duration_s(std::span<const FootPlace> way);

}  // namespace sinew::motion
