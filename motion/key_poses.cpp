#include "motion/key_poses.hpp"

#include <algorithm>

#include "motion/fall.hpp"

namespace sinew::motion {

bool holds(PoseCheck check, const math::Vec3& up) {
  switch (check) {
    case PoseCheck::none:
      return true;
    case PoseCheck::upright:
      return up.z > 0.7;
    case PoseCheck::on_front:
      return lying(up) == FallWay::front;
    case PoseCheck::on_back:
      return lying(up) == FallWay::back;
  }
  return false;
}

std::vector<KeyPose> mirrored(const std::vector<KeyPose>& poses, const kinematics::Body& body) {
  std::vector<KeyPose> out = poses;
  for (std::size_t j = 0; j < body.joints(); ++j) {
    const kinematics::Link& link = body.links[j + 1];
    std::string other = link.name;
    if (other.starts_with("l_"))
      other[0] = 'r';
    else if (other.starts_with("r_"))
      other[0] = 'l';
    const auto link_of_other = body.find_link(other);
    const bool paired = link_of_other && *link_of_other != j + 1;
    const double sign = paired || math::fabs(link.axis.y) > 0.5 ? 1 : -1;
    for (std::size_t i = 0; i < poses.size(); ++i) out[i].rad[j] = sign * poses[i].rad[paired ? *link_of_other - 1 : j];
  }
  return out;
}

void PosePlayer::start(const std::vector<KeyPose>& poses, std::span<const double> from_rad) {
  poses_ = &poses;
  std::copy_n(from_rad.begin(), std::min(from_rad.size(), from_rad_.size()), from_rad_.begin());
  pose_ = 0;
  time_s_ = total_s_ = 0;
  state_ = poses.empty() ? State::done : State::playing;
}

void PosePlayer::step(const math::Vec3& up, double dt_s, std::span<double> targets_rad) {
  if (state_ == State::idle || poses_ == nullptr || poses_->empty()) return;
  const std::size_t joints = std::min(targets_rad.size(), from_rad_.size());
  if (state_ != State::playing) {
    std::copy_n(from_rad_.begin(), joints, targets_rad.begin());
    return;
  }
  time_s_ += dt_s;
  total_s_ += dt_s;
  const KeyPose& to = (*poses_)[pose_];
  const double part = to.duration_s > 0 ? std::clamp(time_s_ / to.duration_s, 0.0, 1.0) : 1;
  const double way = part * part * (3 - 2 * part);
  for (std::size_t j = 0; j < joints; ++j) targets_rad[j] = from_rad_[j] + way * (to.rad[j] - from_rad_[j]);
  if (time_s_ < to.duration_s + to.hold_s - 1e-9) return;
  from_rad_ = to.rad;
  time_s_ = 0;
  if (!holds(to.check, up)) {
    state_ = State::failed;
  } else if (++pose_ == poses_->size()) {
    state_ = State::done;
  }
}

}  // namespace sinew::motion
