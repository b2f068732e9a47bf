#pragma once
#include "math/linear.hpp"
#include "msg/time.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

/// How well a camera follows a ball; only the plant can know.
/// Thread:  owner.
class FollowScore {
 public:
  /// Once every `dt_s`. `hidden`: a part of the ball is covered from the camera, so this time counts neither way.
  void look(msg::Time now, const CameraPose& camera, const math::Vec3& ball_m, const math::Quat& q_world_base,
            bool hidden, double dt_s);
  bool acquired() const { return acquired_; }
  /// The whole ball is in the picture now, and nothing hides it.
  bool in_view() const { return in_view_; }
  /// Since the first acquisition, of the time in which the ball could be seen: the share with the ball in the picture.
  double in_view_share() const { return seen_s_ + missed_s_ > 0 ? seen_s_ / (seen_s_ + missed_s_) : 0; }
  /// RMS of the angle between the optical axis and the ball, over the same time.
  double angle_rms_rad() const { return rms(angle2_); }
  Verdict verdict() const;
  void add_to(JsonObject& report) const;

 private:
  double rms(double sum) const;
  double rms_of_all_deg(double sum) const;

  bool acquired_ = false, in_view_ = false;
  bool was_hidden_ = false;
  msg::Time acquired_at_;
  double on_target_s_ = 0;  // without a break, before the acquisition
  double seen_s_ = 0, missed_s_ = 0, hidden_s_ = 0, loss_s_ = 0, longest_loss_s_ = 0;
  double angle2_ = 0, level2_ = 0, roll2_ = 0, base_tilt2_ = 0;  // integrals of squares
  double angle_max_ = 0;
  std::uint64_t hidings_ = 0;
};

}  // namespace sinew::plant
