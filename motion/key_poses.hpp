#pragma once
// Motions that are a sequence of poses: rising, kicks from a stand.
#include <string>
#include <vector>

#include "motion/figure.hpp"

namespace sinew::motion {

/// What has to be so before a pose is left.
enum class PoseCheck : std::uint8_t {
  none,
  upright,   // the torso's z is within 45 degrees of the vertical
  on_front,  // it lies on its front
  on_back,
};

/// One pose, reached from the one before in `duration_s`, then held.
struct KeyPose {
  std::string name{};
  double duration_s = 0.5, hold_s = 0;
  PoseCheck check = PoseCheck::none;  // at its end; false: the motion has failed
  JointAngles rad{};                  // of all joints
};

/// Plays poses; joints go from one to the next with speed 0 at both ends.
/// Thread:  owner.   RT: yes.
/// Owner:   the poses live as long as they are played.
class PosePlayer {
 public:
  enum class State : std::uint8_t { idle, playing, done, failed };

  /// From these angles, which are the joints' present targets or where they are.
  void start(const std::vector<KeyPose>& poses, std::span<const double> from_rad);
  void stop() { state_ = State::idle; }
  /// State (kept_numbers.hpp), but for the poses: after it was read, resume() gives them.
  template <class Visit>
  void each_part(Visit&& visit) {
    visit(from_rad_, pose_, time_s_, total_s_, state_);
  }
  void resume(const std::vector<KeyPose>* poses) { poses_ = poses; }
  /// `up` in torso axes. Writes targets of all joints while it plays, and after the end those of the last pose.
  void step(const math::Vec3& up, double dt_s, std::span<double> targets_rad);

  State state() const { return state_; }
  std::size_t pose() const { return pose_; }
  double time_s() const { return total_s_; }  // since start()

 private:
  const std::vector<KeyPose>* poses_ = nullptr;
  JointAngles from_rad_{};
  std::size_t pose_ = 0;
  double time_s_ = 0, total_s_ = 0;
  State state_ = State::idle;
};

bool holds(PoseCheck check, const math::Vec3& up);

/// The same poses for the other side: what a joint l_NAME did, r_NAME does. Joints that have no other side turn the
/// other way if they turn about z or x.
std::vector<KeyPose> mirrored(const std::vector<KeyPose>& poses, const kinematics::Body& body);

}  // namespace sinew::motion
