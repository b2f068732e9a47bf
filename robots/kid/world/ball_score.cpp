#include "robots/kid/world/ball_score.hpp"

#include <algorithm>

#include "sim_hil/worlds/json_object.hpp"

namespace sinew::plant {
namespace {

constexpr double kTouchLasts_s = 0.03;  // of a foot and the ball; afterwards its speed is that with which it left
constexpr double kTurnsHead_s = 2;      // until what is seen counts: it gets on its feet and turns its head

}  // namespace

void BallScore::look(const BallTruth& ball, bool touched, const kinematics::Pose& camera, bool looks, double now_s) {
  constexpr double kKick_mps = 0.5, kSlow_mps = 0.3;
  const double before_mps = mps_;
  mps_ = math::hypot(ball.v_mps.x, ball.v_mps.y);
  if (touched) ball_s_ += now_s - looked_at_s_;
  looked_at_s_ = now_s;
  if (touched && !rolls_ && mps_ >= kKick_mps) {
    rolls_ = true;
    ++kicks_;
  } else if (!touched || mps_ < kSlow_mps) {
    rolls_ = false;
  }
  if (touched && touched_s_ < 0) {
    touched_s_ = now_s;
    came_mps_ = before_mps;
  }
  if (touched && now_s > touched_s_ + kTouchLasts_s) left_mps_ = std::max(left_mps_, mps_);

  if (!looks) {
    looked_s_ = -1;
    return;
  }
  if (looked_s_ < 0) looked_s_ = now_s;
  if (now_s < looked_s_ + kTurnsHead_s) return;
  const math::Vec3 axis = camera.q.rotate({1, 0, 0}), to = ball.p_m - camera.p_m;
  const double off_rad = math::atan2(norm(cross(axis, to)), dot(axis, to));
  off_axis_rad_ += off_rad;
  most_off_axis_rad_ = std::max(most_off_axis_rad_, off_rad);
  ++looks_;
}

void BallScore::add_to(JsonObject& j) const {
  constexpr double kDegrees = 180 / math::kPi;
  j.boolean("ball_touched", touched());
  if (touched()) {
    j.number("ball_came_mps", came_mps_);
    j.number("ball_left_mps", left_mps_);
    j.integer("kicks", kicks_);
    j.number("ball_s", ball_s_);
  }
  j.number("ball_mps", mps_);
  if (looks_ > 0) {
    j.number("ball_off_axis_deg", off_axis_rad_ / static_cast<double>(looks_) * kDegrees);
    j.number("ball_off_axis_most_deg", most_off_axis_rad_ * kDegrees);
  }
}

}  // namespace sinew::plant
