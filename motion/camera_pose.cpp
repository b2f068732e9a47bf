#include "motion/camera_pose.hpp"

#include <algorithm>

namespace sinew::motion {
namespace {

/// x ahead, y left, z up to x right, y down, z ahead.
constexpr math::Quat kQOptical{0.5, -0.5, 0.5, -0.5};

}  // namespace

kinematics::Pose camera_pose(const kinematics::BodyPose& pose, const kinematics::Place& camera) {
  const kinematics::Pose at = pose.place(camera);
  return {at.p_m, at.q * kQOptical};
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
