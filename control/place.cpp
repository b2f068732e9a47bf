#include "control/place.hpp"

namespace sinew::control {
namespace {

using math::Mat;
using math::Mat3;
using math::Vec3;

/// What the error of a pose does to a place at `d` from the robot, in the team's axes.
Mat3 lever_covariance(const UncertainPose& robot, const Vec3& d) {
  Mat<3, 6> j;
  j.set_block(0, 0, Mat3::identity());
  j.set_block(0, 3, -math::skew(d));
  return j * robot.covariance * j.transpose();
}

}  // namespace

UncertainPose to_pose(const msg::TeamPose& message) {
  UncertainPose pose;
  pose.p_m = Vec3(message.p_team_m);
  pose.q = math::Quat(message.q_team_base);
  pose.covariance.a = message.covariance;
  return pose;
}

Place to_team(const UncertainPose& robot, const Place& in_robot) {
  const Vec3 d = robot.q.rotate(in_robot.p_m);
  const Mat3 c = robot.q.matrix();
  return {robot.p_m + d, (lever_covariance(robot, d) + c * in_robot.covariance_m2 * c.transpose()).symmetric()};
}

Place from_team(const UncertainPose& robot, const Place& in_team) {
  const Vec3 d = in_team.p_m - robot.p_m;
  const Mat3 c = robot.q.matrix();
  const Mat3 of_d = lever_covariance(robot, d) + in_team.covariance_m2;
  return {robot.q.conjugate().rotate(d), (c.transpose() * of_d * c).symmetric()};
}

}  // namespace sinew::control
