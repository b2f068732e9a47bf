#include "motion/pose_motions.hpp"

namespace sinew::motion {

PoseMotions::PoseMotions(const MotionBook& book, const kinematics::Body& body) {
  const auto set = [&](PoseMotion motion, const std::vector<KeyPose>* poses) {
    poses_[static_cast<std::size_t>(motion)] = poses;
  };
  const auto set_mirrored = [&](PoseMotion of, PoseMotion motion, std::vector<KeyPose>& into) {
    if (!has(of)) return;
    into = mirrored(*poses(of), body);
    set(motion, &into);
  };
  set(PoseMotion::rise_front, book.find("rise_front"));
  set(PoseMotion::rise_back, book.find("rise_back"));
  set(PoseMotion::turn_from_left, book.find("turn_from_left"));
  set(PoseMotion::unfold, book.find("unfold"));
  set(PoseMotion::get_down, book.find("get_down"));
  set_mirrored(PoseMotion::rise_back, PoseMotion::rise_back_mirrored, rise_back_mirrored_);
  set_mirrored(PoseMotion::turn_from_left, PoseMotion::turn_from_right, turn_from_right_);
}

PoseMotion PoseMotions::rise_from(FallWay lies_on, PoseMotion last) const {
  PoseMotion motion = PoseMotion::none;
  switch (lies_on) {
    case FallWay::none:
      motion = PoseMotion::unfold;
      break;
    case FallWay::front:
      motion = PoseMotion::rise_front;
      break;
    case FallWay::back:
      motion = last == PoseMotion::rise_back ? PoseMotion::rise_back_mirrored : PoseMotion::rise_back;
      break;
    case FallWay::left:
      motion = PoseMotion::turn_from_left;
      break;
    case FallWay::right:
      motion = PoseMotion::turn_from_right;
      break;
  }
  return has(motion) ? motion : PoseMotion::none;
}

}  // namespace sinew::motion
