#pragma once
// How a body stands, from what it measures.
#include "motion/figure.hpp"
#include "motion/planar.hpp"

namespace sinew::motion {

/// From measured joints, attitude and soles. Frames of soles: origin in the middle of the sole, x to its toes, level.
struct Stance {
  std::array<math::Vec3, 2> com_m;   // the centre of mass in each sole's frame
  std::array<Planar, 2> torso;       // the torso's origin in each sole's frame
  std::array<double, 2> height_m{};  // of the torso's origin over each sole's lowest corner
  Planar right_to_left;              // the left sole's frame in the right one's
  std::array<double, 2> load{};      // share of the body's weight on each sole
  std::array<double, 2> raised_m{};  // each sole's middle over its lowest corner: it stands on an edge
  std::array<Vec2, 2> cop_m;         // where the ground pushes each sole, in its frame; its middle without load

  /// The frame of the other sole in this one's.
  Planar to_other(Side side) const { return side == Side::right ? right_to_left : right_to_left.inverse(); }
};

/// Thread:  owner.   RT: yes.
class StanceSense {
 public:
  explicit StanceSense(const Figure& figure) : figure_(&figure), pose_(figure.body()) {}
  /// `q_level_torso`: attitude; its yaw does not matter. `cell_inset_m`: of the force cells from the sole's edges.
  void step(const Sensed& sensed, const math::Quat& q_level_torso, double cell_inset_m);
  const Stance& stance() const { return stance_; }

 private:
  const Figure* figure_;
  kinematics::BodyPose pose_;
  Stance stance_;
};

}  // namespace sinew::motion
