#pragma once
// Where a camera of a walking body was at the middle of an exposure.
//
//   CameraChain chain(figure, *body.find_place("camera"));
//   CameraHistory history;
//   history.add(stamp_ns, chain.camera(torso, joints_rad));        // with each measurement of the joints
//   if (history.at(exposed_ns, pose) == CameraHistory::Found::yes) // between two of them
//     pose.of({0, 0, 1});                                          // 1 m ahead of the lens, in the world
//
// Frames:  world: that of the odometry, z up, 0 on the ground; the camera's: optical, x right, y down, z ahead.
#include <array>
#include <cstdint>

#include "motion/figure.hpp"
#include "motion/planar.hpp"

namespace sinew::motion {

/// The chain from the ground over the legs, the torso and the neck to a camera.
/// Thread:  owner.   RT: yes, after the constructor.
/// Owner:   figure and place live as long.
class CameraChain {
 public:
  CameraChain(const Figure& figure, const kinematics::Place& camera)
      : figure_(&figure), camera_(&camera), pose_(figure.body()) {}

  /// `q_world_torso` and `joints_rad` are of one instant; `torso_m` is the torso on the ground, by odometry. The lowest
  /// corner of the soles is taken to be on the ground.
  kinematics::Pose camera(const math::Quat& q_world_torso, const Vec2& torso_m, std::span<const double> joints_rad);

 private:
  const Figure* figure_;
  const kinematics::Place* camera_;
  kinematics::BodyPose pose_;
};

/// The last poses of one camera; a state of modules.
/// Thread:  owner.   RT: yes.
class CameraHistory {
 public:
  enum class Found : std::uint8_t { yes, not_yet, too_old };

  constexpr CameraHistory() = default;
  /// Measurements come in order; one that is not later than the newest is left out.
  void add(std::int64_t stamp_ns, const kinematics::Pose& pose);
  /// Between the two measurements around the instant: the place on the straight line, the attitude on the great arc.
  Found at(std::int64_t stamp_ns, kinematics::Pose& out) const;

 private:
  static constexpr std::size_t kMost = 32;  // 256 ms at 125 Hz
  struct Sample {
    std::int64_t stamp_ns = 0;
    math::Vec3 p_m;
    math::Quat q;
  };
  const Sample& back(std::size_t age) const { return sample_[(count_ - 1 - age) % kMost]; }

  std::array<Sample, kMost> sample_{};
  std::uint64_t count_ = 0;
};

}  // namespace sinew::motion
