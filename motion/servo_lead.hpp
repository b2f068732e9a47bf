#pragma once
// What targets need so that soft, slow servos arrive where the motion wants them.
#include "motion/figure.hpp"
#include "motion/planar.hpp"

namespace sinew::motion {

/// How a leg is loaded: the ground pushes at a point of its sole.
struct LegLoad {
  math::Vec3 push_n, at_m;  // torso axes and frame
};

struct ServoLeadParams {
  double lead_s = 0;          // targets are ahead by so much, by their rate
  double gain_per_rad = 4.6;  // of the servos: share of the stall torque for a radian of error
  double weight_ahead = 0;    // how much of their yielding is taken out, 0 to 1
  double play_rad = 0;        // width of the gear's play, taken up on the loaded side
};

/// Thread:  owner.   RT: yes, after the constructor.
class ServoLead {
 public:
  explicit ServoLead(const Figure& figure) : figure_(&figure), pose_(figure.body()) {}
  void reset() { begun_ = false; }
  /// State (kept_numbers.hpp).
  template <class Visit>
  void each_part(Visit&& visit) {
    visit(before_, begun_);
  }
  /// `angles_rad`: where all joints should be at this instant; becomes their targets. Rates are those of the legs'
  /// joints, the torque is what each leg's load takes, the legs' own weight left out.
  void step(const ServoLeadParams& params, const std::array<LegLoad, 2>& loads, double dt_s,
            std::span<double> angles_rad);

 private:
  const Figure* figure_;
  kinematics::BodyPose pose_;
  JointAngles before_{};
  bool begun_ = false;
};

}  // namespace sinew::motion
