#include "motion/camera_pose.hpp"

#include <algorithm>

namespace sinew::motion {
namespace {

/// x ahead, y left, z up to x right, y down, z ahead.
constexpr math::Quat kQOptical{0.5, -0.5, 0.5, -0.5};

}  // namespace

kinematics::Pose CameraChain::camera(const math::Quat& q_world_torso, const Vec2& torso_m,
                                     std::span<const double> joints_rad) {
  pose_.set(joints_rad, {{}, q_world_torso});
  double lowest_m = math::kInf;
  for (const Side side : kSides) {
    const LegOfFigure& leg = figure_->leg(side);
    const kinematics::Pose sole = figure_->sole(pose_, side);
    for (const double x : {-0.5, 0.5})
      for (const double y : {-0.5, 0.5})
        lowest_m = std::min(lowest_m, sole.of({x * leg.sole_length_m, y * leg.sole_width_m, 0}).z);
  }
  const kinematics::Pose camera = pose_.place(*camera_);
  return {camera.p_m + math::Vec3{torso_m.x, torso_m.y, -lowest_m}, camera.q * kQOptical};
}

void CameraHistory::add(std::int64_t stamp_ns, const kinematics::Pose& pose) {
  if (count_ > 0 && stamp_ns <= back(0).stamp_ns) return;
  sample_[count_ % kMost] = {stamp_ns, pose.p_m, pose.q};
  ++count_;
}

CameraHistory::Found CameraHistory::at(std::int64_t stamp_ns, kinematics::Pose& out) const {
  if (count_ == 0 || stamp_ns > back(0).stamp_ns) return Found::not_yet;
  const auto kept = static_cast<std::size_t>(std::min<std::uint64_t>(count_, kMost));
  for (std::size_t age = 0; age < kept; ++age) {
    const Sample& before = back(age);
    if (before.stamp_ns > stamp_ns) continue;
    if (before.stamp_ns == stamp_ns) {
      out = {before.p_m, before.q};
      return Found::yes;
    }
    const Sample& after = back(age - 1);  // the newest is not before this instant
    const double part =
        static_cast<double>(stamp_ns - before.stamp_ns) / static_cast<double>(after.stamp_ns - before.stamp_ns);
    out.p_m = before.p_m + part * (after.p_m - before.p_m);
    out.q = (before.q * math::Quat::exp(part * (before.q.conjugate() * after.q).log())).normalized();
    return Found::yes;
  }
  return Found::too_old;
}

}  // namespace sinew::motion
