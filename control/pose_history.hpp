#pragma once
#include <array>
#include <optional>

#include "math/linear.hpp"
#include "msg/time.hpp"

namespace sinew::control {

/// Past poses and velocities: a late measurement is compared with the estimate of its own instant.
/// Shape:   ring of 64 poses at least 5 ms apart, so a third of a second at 200 Hz or more.
/// Thread:  owner.   RT: yes.
class PoseHistory {
 public:
  struct Pose {
    msg::Time stamp;
    math::Vec3 p_world_m;
    math::Quat q_world_base;
    math::Vec3 v_world_mps{};
  };

  void clear() { count_ = 0; }
  void add(const Pose& pose) {
    if (count_ && pose.stamp - newest().stamp < kSpacing) return;
    ring_[(first_ + count_) % kPoses] = pose;
    if (count_ < kPoses) {
      ++count_;
    } else {
      first_ = (first_ + 1) % kPoses;
    }
  }
  /// Moves all positions along with a correction of the present one.
  void shift(const math::Vec3& dp_world_m) {
    for (std::size_t i = 0; i < count_; ++i) ring_[(first_ + i) % kPoses].p_world_m += dp_world_m;
  }
  /// Moves all poses along with a correction of the present one, each by what the correction means for its own instant
  /// (`now`: of the present pose): the velocity's correction changed the position since then, too.
  void correct(msg::Time now, const math::Vec3& dp_world_m, const math::Vec3& dv_world_mps, const math::Vec3& turn) {
    const math::Quat q = math::Quat::exp(turn);
    for (std::size_t i = 0; i < count_; ++i) {
      Pose& pose = ring_[(first_ + i) % kPoses];
      pose.p_world_m += dp_world_m - dv_world_mps * msg::seconds(now - pose.stamp);
      pose.v_world_mps += dv_world_mps;
      pose.q_world_base = q * pose.q_world_base;
    }
  }
  /// Turns the world under all of them about the vertical through the origin.
  void turn_world(double angle_rad) {
    const math::Quat turn = math::Quat::from_axis_angle({0, 0, 1}, angle_rad);
    for (std::size_t i = 0; i < count_; ++i) {
      Pose& pose = ring_[(first_ + i) % kPoses];
      pose.p_world_m = turn.rotate(pose.p_world_m);
      pose.v_world_mps = turn.rotate(pose.v_world_mps);
      pose.q_world_base = turn * pose.q_world_base;
    }
  }
  /// Linear between two poses; after the newest pose, the newest pose; before the oldest, nothing.
  std::optional<Pose> at(msg::Time t) const {
    if (!count_ || t < entry(0).stamp) return std::nullopt;
    for (std::size_t i = count_; i-- > 0;) {
      const Pose& a = entry(i);
      if (a.stamp > t) continue;
      if (i + 1 == count_) return a;
      const Pose& b = entry(i + 1);
      const double s = static_cast<double>((t - a.stamp).count()) / static_cast<double>((b.stamp - a.stamp).count());
      const math::Vec3 turn = (a.q_world_base.conjugate() * b.q_world_base).log();
      return Pose{t, a.p_world_m + (b.p_world_m - a.p_world_m) * s,
                  (a.q_world_base * math::Quat::exp(turn * s)).normalized(),
                  a.v_world_mps + (b.v_world_mps - a.v_world_mps) * s};
    }
    return std::nullopt;
  }

 private:
  static constexpr std::size_t kPoses = 64;
  static constexpr msg::Duration kSpacing{5'000'000};
  const Pose& entry(std::size_t i) const { return ring_[(first_ + i) % kPoses]; }
  const Pose& newest() const { return entry(count_ - 1); }

  std::array<Pose, kPoses> ring_{};
  std::uint32_t first_ = 0, count_ = 0;  // as wide on every machine: a state has no padding
};

}  // namespace sinew::control
