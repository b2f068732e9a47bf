#include "kinematics/body.hpp"

#include <algorithm>
#include <cstdlib>

namespace sinew::kinematics {

using math::Quat;
using math::Vec3;

std::optional<std::size_t> Body::find_link(std::string_view link) const {
  const auto it = std::find_if(links.begin(), links.end(), [&](const Link& l) { return l.name == link; });
  if (it == links.end()) return std::nullopt;
  return static_cast<std::size_t>(it - links.begin());
}

const Place* Body::find_place(std::string_view place) const {
  const auto it = std::find_if(places.begin(), places.end(), [&](const Place& p) { return p.name == place; });
  return it == places.end() ? nullptr : &*it;
}

double Body::mass_kg() const {
  double sum = 0;
  for (const Link& l : links) sum += l.mass_kg;
  return sum;
}

BodyPose::BodyPose(const Body& body) : body_(&body), mass_kg_(body.mass_kg()) {
  if (body.links.empty() || body.links.size() > kMaxLinks) std::abort();  // readers of bodies refuse them
  const std::array<double, kMaxLinks> zero{};
  set({zero.data(), body.joints()});
}

void BodyPose::set(std::span<const double> joints_rad, const Pose& base) {
  pose_[0] = base;
  for (std::size_t i = 1; i < body_->links.size(); ++i) {
    const Link& link = body_->links[i];
    const Pose& parent = pose_[link.parent];
    const double angle_rad = i - 1 < joints_rad.size() ? joints_rad[i - 1] : 0;
    pose_[i] = {parent.of(link.at_m), parent.q * Quat::from_axis_angle(link.axis, angle_rad)};
  }
}

Vec3 BodyPose::centre_of_mass() const {
  Vec3 sum;
  for (std::size_t i = 0; i < body_->links.size(); ++i)
    sum += pose_[i].of(body_->links[i].com_m) * body_->links[i].mass_kg;
  return mass_kg_ > 0 ? sum / mass_kg_ : pose_[0].p_m;
}

void BodyPose::jacobian(std::size_t link, const Vec3& point_m, std::span<Vec3> linear, std::span<Vec3> angular) const {
  std::fill(linear.begin(), linear.end(), Vec3{});
  std::fill(angular.begin(), angular.end(), Vec3{});
  const Vec3 point = pose_[link].of(point_m);
  for (std::size_t i = link; i != 0; i = body_->links[i].parent) {
    const Vec3 axis = pose_[i].q.rotate(body_->links[i].axis);
    if (i - 1 < linear.size()) linear[i - 1] = cross(axis, point - pose_[i].p_m);
    if (i - 1 < angular.size()) angular[i - 1] = axis;
  }
}

void BodyPose::jacobian_of_centre_of_mass(std::span<Vec3> linear) const {
  std::fill(linear.begin(), linear.end(), Vec3{});
  // What hangs on each link, from the outermost one inwards: mass, and mass times place.
  std::array<double, kMaxLinks> mass{};
  std::array<Vec3, kMaxLinks> moment{};
  for (std::size_t i = body_->links.size(); i-- > 0;) {
    const Link& link = body_->links[i];
    mass[i] += link.mass_kg;
    moment[i] += pose_[i].of(link.com_m) * link.mass_kg;
    if (i == 0) break;
    mass[link.parent] += mass[i];
    moment[link.parent] += moment[i];
    const Vec3 axis = pose_[i].q.rotate(link.axis);
    if (i - 1 < linear.size() && mass_kg_ > 0)
      linear[i - 1] = cross(axis, moment[i] - pose_[i].p_m * mass[i]) / mass_kg_;
  }
}

}  // namespace sinew::kinematics
