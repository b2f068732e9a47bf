#pragma once
// What one robot sees, as a place for another one: through the poses of both, with what is uncertain about them.
// Thread:  any.   RT: yes.
#include "math/linear.hpp"
#include "msg/team.hpp"

namespace sinew::control {

/// A point, and how sure it is.
struct Place {
  math::Vec3 p_m;
  math::Mat3 covariance_m2;
};

/// The pose of a frame (of a robot) in another one (of the team).
struct UncertainPose {
  math::Vec3 p_m;
  math::Quat q;  // takes the robot's coordinates to the team's
  /// Of position (m) and of a small rotation (rad), which turns the true orientation out of `q` and is given in the
  /// team's axes. Position first.
  math::Mat<6, 6> covariance;
};
/// The message's numbers.
UncertainPose to_pose(const msg::TeamPose& message);

/// A place in the robot's frame, in the team's frame. The errors of pose and place are independent.
/// First order in the rotation's error t: p + q(r) + dp + t x q(r) + q(dr), so the pose's part is J C J^T with
/// J = [I, -[q(r)]x].
/// Source:  R. Smith, P. Cheeseman: On the representation and estimation of spatial uncertainty, IJRR 5(4), 1986.
Place to_team(const UncertainPose& robot, const Place& in_robot);

/// A place in the team's frame, in the robot's frame: the inverse, likewise to first order; with d from the robot to
/// the place, J = [I, -[d]x].
Place from_team(const UncertainPose& robot, const Place& in_team);

}  // namespace sinew::control
