#include "motion/gaze.hpp"

#include <algorithm>

namespace sinew::motion {

Gaze::Gaze(const Figure& figure) : figure_(&figure), pose_(figure.body()) {
  for (const kinematics::Place& place : figure.body().places) {
    if (!place.name.starts_with("camera") || place.link != figure.head_tilt() + 1) continue;
    camera_ = place.pose;
    const math::Vec3 axis = camera_.q.rotate({1, 0, 0});
    own_down_rad_ = -math::atan2(axis.z, math::hypot(axis.x, axis.y));
    break;
  }
}

void Gaze::reset() {
  rate_ = {};
  begun_ = limited_ = false;
  error_rad_ = 0;
}

void Gaze::look_along(const math::Vec3& ahead_world) {
  aim_ = Aim::direction;
  to_ = ahead_world;
}
void Gaze::look_at(const math::Vec3& point_world_m) {
  aim_ = Aim::point;
  to_ = point_world_m;
}
void Gaze::look_level() { aim_ = Aim::level; }

void Gaze::step(const kinematics::Pose& torso, const math::Vec3& rate_radps, std::span<const double> joints_rad,
                double dt_s, std::span<double> targets_rad) {
  const std::size_t pan = figure_->head_pan(), tilt = figure_->head_tilt();
  if (pan == kinematics::kNone || tilt == kinematics::kNone) return;
  rate_ += (rate_radps - rate_) * (dt_s / (dt_s + params.rate_smooth_s));
  pose_.set(joints_rad, torso);
  const kinematics::Pose camera = pose_.link(tilt + 1) * camera_;
  math::Vec3 to = to_;  // in the world, from the camera
  if (aim_ == Aim::point) to = to_ - camera.p_m;
  if (aim_ == Aim::level) {
    to = torso.q.rotate({1, 0, 0});
    to.z = 0;
  }
  error_rad_ = math::atan2(norm(cross(camera.q.rotate({1, 0, 0}), to)), dot(camera.q.rotate({1, 0, 0}), to));
  const math::Quat then = (torso.q * math::Quat::exp(rate_ * params.lag_s)).normalized();
  if (aim_ == Aim::level) {
    to = then.rotate({1, 0, 0});
    to.z = 0;
  }
  const math::Vec3 ahead = then.conjugate().rotate(to);
  const auto& links = figure_->body().links;
  const double pan_sign = links[pan + 1].axis.z < 0 ? -1 : 1, tilt_sign = links[tilt + 1].axis.y < 0 ? -1 : 1;
  const double flat = math::hypot(ahead.x, ahead.y);
  std::array<double, 2> wanted{set_rad_[0],
                               -tilt_sign * (math::atan2(ahead.z, flat) + own_down_rad_ + params.camera_down_rad)};
  if (flat > 1e-3 * norm(ahead)) wanted[0] = pan_sign * math::atan2(ahead.y, ahead.x);
  limited_ = false;
  const std::array<std::size_t, 2> joint{pan, tilt};
  for (std::size_t i = 0; i < 2; ++i) {
    const double within = std::clamp(wanted[i], links[joint[i] + 1].least_rad, links[joint[i] + 1].most_rad);
    if (within != wanted[i]) limited_ = true;
    if (!begun_) set_rad_[i] = joints_rad[joint[i]];
    set_rad_[i] += std::clamp(within - set_rad_[i], -params.speed_radps * dt_s, params.speed_radps * dt_s);
    targets_rad[joint[i]] = set_rad_[i];
  }
  begun_ = true;
}

}  // namespace sinew::motion
