#pragma once
// Where a camera of a walking body was at the middle of an exposure.
//
//   CameraHistory history;
//   history.add(stamp_ns, camera_pose(pose, *body.find_place("camera")));  // with each measurement of the joints
//   if (history.at(exposed_ns, camera) == CameraHistory::Found::yes)       // between two of them
//     camera.of({0, 0, 1});                                                // 1 m ahead of the lens
//
// Frames:  of what is added; a camera's own is optical: x right, y down, z ahead.
#include <array>
#include <cstdint>

#include "kinematics/body.hpp"

namespace sinew::motion {

/// The optical frame of a camera in the frame that `pose` was set in.
kinematics::Pose camera_pose(const kinematics::BodyPose& pose, const kinematics::Place& camera);

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
