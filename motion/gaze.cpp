#include "motion/gaze.hpp"

#include <algorithm>

namespace sinew::motion {

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
  const kinematics::Pose then{torso.p_m, (torso.q * math::Quat::exp(rate_ * params.lag_s)).normalized()};

  math::Vec3 ahead{1, 0, 0};  // in the torso's axes
  if (aim_ == Aim::direction) {
    ahead = then.q.conjugate().rotate(to_);
  } else if (aim_ == Aim::point) {
    pose_.set(joints_rad, then);
    ahead = then.q.conjugate().rotate(to_ - pose_.link(tilt + 1).p_m);
  } else {
    const math::Vec3 forward = then.q.rotate({1, 0, 0});
    ahead = then.q.conjugate().rotate({forward.x, forward.y, 0});
  }
  const auto& links = figure_->body().links;
  const double pan_sign = links[pan + 1].axis.z < 0 ? -1 : 1, tilt_sign = links[tilt + 1].axis.y < 0 ? -1 : 1;
  const double flat = math::hypot(ahead.x, ahead.y);
  std::array<double, 2> wanted{set_rad_[0],
                               -tilt_sign * math::atan2(ahead.z, flat) - tilt_sign * params.camera_down_rad};
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
