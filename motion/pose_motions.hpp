#pragma once
// Which motions a body has that are poses, and by which of them it comes from the ground towards standing.
#include <array>
#include <vector>

#include "motion/fall.hpp"
#include "motion/motion_book.hpp"

namespace sinew::motion {

enum class PoseMotion : std::uint8_t {
  none,
  rise_front,
  rise_back,
  rise_back_mirrored,  // over the other side
  turn_from_left,      // from its left side onto its front
  turn_from_right,
  unfold,  // of a body that leans on its own limbs: it then stands, or falls over and lies
  get_down,
};
inline constexpr std::size_t kPoseMotions = 8;

/// Those of a motion file: "rise_front", "rise_back", "turn_from_left", "unfold", "get_down"; the others are made of
/// these with left and right exchanged. A file may leave any of them out. Thread:  any, const.   RT: yes, but the
/// constructor. Owner:   the book lives as long. Not moved: poses() are inside.
class PoseMotions {
 public:
  PoseMotions() = default;
  PoseMotions(const MotionBook& book, const kinematics::Body& body);
  PoseMotions(const PoseMotions&) = delete;
  PoseMotions& operator=(const PoseMotions&) = delete;

  /// Null: the file has none.
  const std::vector<KeyPose>* poses(PoseMotion motion) const { return poses_[static_cast<std::size_t>(motion)]; }
  bool has(PoseMotion motion) const { return poses(motion) != nullptr; }

  /// What a body at rest that lies so, none: that leans, does next; `last` is what it did last. Where one side is
  /// blocked the next try from the back goes over the other one. PoseMotion::none: nothing helps, it stays there.
  PoseMotion rise_from(FallWay lies_on, PoseMotion last) const;

 private:
  std::array<const std::vector<KeyPose>*, kPoseMotions> poses_{};
  std::vector<KeyPose> rise_back_mirrored_{}, turn_from_right_{};
};

}  // namespace sinew::motion
