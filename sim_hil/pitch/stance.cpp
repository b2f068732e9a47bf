#include "sim_hil/pitch/stance.hpp"

#include <algorithm>
#include <string>

namespace sinew::plant {
namespace {

using kinematics::Shape;
using math::Quat;
using math::Vec3;

Quat lying(PitchPlace::Lie lie) {
  switch (lie) {
    case PitchPlace::Lie::upright:
      break;
    case PitchPlace::Lie::on_front:
      return Quat::from_axis_angle({0, 1, 0}, math::kPi / 2);
    case PitchPlace::Lie::on_back:
      return Quat::from_axis_angle({0, 1, 0}, -math::kPi / 2);
    case PitchPlace::Lie::on_left:
      return Quat::from_axis_angle({1, 0, 0}, -math::kPi / 2);
    case PitchPlace::Lie::on_right:
      return Quat::from_axis_angle({1, 0, 0}, math::kPi / 2);
  }
  return {};
}

/// How far a shape reaches down from its middle, which is turned by q in the world.
double reach_down_m(const Shape& s, const Quat& q) {
  const Vec3 down = q.conjugate().rotate({0, 0, 1});  // the vertical in its axes
  switch (s.kind) {
    case Shape::Kind::box:
      return (math::fabs(down.x) * s.size_m.x + math::fabs(down.y) * s.size_m.y + math::fabs(down.z) * s.size_m.z) / 2;
    case Shape::Kind::capsule:
      return s.size_m.x + math::fabs(down.z) * s.size_m.z / 2;
    case Shape::Kind::sphere:
      break;
  }
  return s.size_m.x;
}

}  // namespace

double lowest_point_m(const kinematics::BodyPose& pose) {
  double lowest = math::kInf;
  const kinematics::Body& body = pose.body();
  for (std::size_t i = 0; i < body.links.size(); ++i)
    for (const Shape& s : body.links[i].shapes)
      if (s.contact) lowest = std::min(lowest, pose.link(i).of(s.at_m).z - reach_down_m(s, pose.link(i).q * s.q));
  return math::is_finite(lowest) ? lowest : pose.link(0).p_m.z;
}

kinematics::Pose pose_on_ground(const kinematics::Body& body, const PitchPlace& at, double above_m) {
  kinematics::Pose base{{at.x_m, at.y_m, 0}, Quat::from_axis_angle({0, 0, 1}, at.heading_rad) * lying(at.lie)};
  kinematics::BodyPose pose(body);
  pose.set(at.joints_rad, base);
  base.p_m.z = above_m - lowest_point_m(pose);
  return base;
}

std::array<std::optional<Sole>, 2> soles_of(const kinematics::Body& body) {
  std::array<std::optional<Sole>, 2> out;
  for (std::size_t side = 0; side < 2; ++side) {
    const kinematics::Place* const place = body.find_place(side == 0 ? "l_sole" : "r_sole");
    if (!place) continue;
    double nearest = math::kInf;
    const auto& shapes = body.links[place->link].shapes;
    for (std::size_t i = 0; i < shapes.size(); ++i) {
      const double far = norm(shapes[i].at_m - place->pose.p_m);
      if (shapes[i].kind != Shape::Kind::box || !shapes[i].contact || far >= nearest) continue;
      nearest = far;
      out[side] = Sole{place->link, i, {shapes[i].at_m, shapes[i].q}, shapes[i].size_m * 0.5};
    }
  }
  return out;
}

std::array<double, 4> cell_shares(const Sole& sole, const math::Vec3& at) {
  const auto share = [](double x, double half) { return std::clamp(0.5 + 0.5 * x / half, 0.0, 1.0); };
  const double front = share(at.x, sole.half_m.x), left = share(at.y, sole.half_m.y);
  return {front * left, front * (1 - left), (1 - front) * left, (1 - front) * (1 - left)};
}

}  // namespace sinew::plant
