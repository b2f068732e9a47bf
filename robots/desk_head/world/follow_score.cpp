#include "robots/desk_head/world/follow_score.hpp"

#include <algorithm>

#include "robots/desk_head/world/head_body.hpp"
#include "sim_hil/worlds/json_object.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {
namespace {

using math::Vec3;

constexpr double kOnTarget_rad = 0.052, kHolds_s = 0.3;  // 3 deg for so long: acquired
// Half the picture, 4:3, in tangents.
constexpr double kHalfHeight = 0.5 / kFocalPerHeight, kHalfWidth = kHalfHeight * 4 / 3;

double degrees(double rad) { return rad * (180 / math::kPi); }

}  // namespace

void FollowScore::look(msg::Time now, const CameraPose& camera, const Vec3& ball_m, const math::Quat& q_world_base,
                       bool hidden, double dt_s) {
  const math::Quat q(camera.q_world_optical);
  const Vec3 d = q.conjugate().rotate(ball_m - Vec3(camera.p_world_m));
  const double angle = math::atan2(math::hypot(d.x, d.y), d.z);
  const double edge = kBallRadius / d.z;  // of its image, beyond the image of its centre
  const bool inside =
      d.z > kBallRadius && math::fabs(d.x / d.z) + edge < kHalfWidth && math::fabs(d.y / d.z) + edge < kHalfHeight;
  in_view_ = inside && !hidden;
  if (!acquired_) {
    on_target_s_ = in_view_ && angle < kOnTarget_rad ? on_target_s_ + dt_s : 0;
    acquired_ = on_target_s_ >= kHolds_s;
    acquired_at_ = now;
    return;
  }
  if (hidden && !was_hidden_) ++hidings_;
  was_hidden_ = hidden;
  const Vec3 axis = q.rotate({0, 0, 1}), right = q.rotate({1, 0, 0});
  const Vec3 up = q_world_base.rotate({0, 0, 1});
  const double roll = math::asin(std::clamp(right.z, -1.0, 1.0));
  roll2_ += roll * roll * dt_s;
  const double tilt = math::atan2(math::hypot(up.x, up.y), up.z);
  base_tilt2_ += tilt * tilt * dt_s;
  if (hidden) {
    hidden_s_ += dt_s;
    loss_s_ = 0;
    return;
  }
  const Vec3 sight = math::normalized(ball_m - Vec3(camera.p_world_m));
  const double level = math::asin(std::clamp(axis.z, -1.0, 1.0)) - math::asin(std::clamp(sight.z, -1.0, 1.0));
  level2_ += level * level * dt_s;
  angle2_ += angle * angle * dt_s;
  angle_max_ = std::max(angle_max_, angle);
  (inside ? seen_s_ : missed_s_) += dt_s;
  loss_s_ = inside ? 0 : loss_s_ + dt_s;
  longest_loss_s_ = std::max(longest_loss_s_, loss_s_);
}

double FollowScore::rms(double sum) const {
  const double s = seen_s_ + missed_s_;
  return s > 0 ? math::sqrt(sum / s) : 0;
}

double FollowScore::rms_of_all_deg(double sum) const {
  const double all_s = seen_s_ + missed_s_ + hidden_s_;
  return all_s > 0 ? degrees(math::sqrt(sum / all_s)) : 0;
}

Verdict FollowScore::verdict() const {
  constexpr double kLeastShare = 0.95, kMostAngle_deg = 3;
  const double angle_deg = degrees(angle_rms_rad());
  Verdict verdict;
  verdict.measures = {{"in_view_share", "ball in view", "of the time it could be", in_view_share(), kLeastShare, true},
                      {"longest_loss_s", "longest loss", "s", longest_loss_s_},
                      {"angle_rms_deg", "ball off the axis", "deg RMS", angle_deg, kMostAngle_deg},
                      {"level_rms_deg", "elevation", "deg RMS", degrees(rms(level2_))},
                      {"roll_rms_deg", "horizon", "deg RMS", rms_of_all_deg(roll2_)},
                      {"base_tilt_rms_deg", "tilt of the base", "deg RMS", rms_of_all_deg(base_tilt2_)}};
  verdict.good = acquired_ && in_view_share() >= kLeastShare && angle_deg < kMostAngle_deg;
  if (!acquired_)
    verdict.outcome = "never found the ball";
  else
    verdict.outcome = verdict.good ? "followed the ball" : "did not keep the ball in view";
  return verdict;
}

void FollowScore::add_to(JsonObject& j) const {
  j.boolean("acquired", acquired_);
  if (acquired_) j.number("acquired_s", msg::seconds(acquired_at_));
  j.number("visible_s", seen_s_ + missed_s_);
  j.number("hidden_s", hidden_s_);
  j.integer("hidings", hidings_);
  j.number("in_view_share", in_view_share());
  j.number("angle_rms_deg", degrees(angle_rms_rad()));
  j.number("angle_max_deg", degrees(angle_max_));
  j.number("level_rms_deg", degrees(rms(level2_)));
  j.number("roll_rms_deg", rms_of_all_deg(roll2_));
  j.number("base_tilt_rms_deg", rms_of_all_deg(base_tilt2_));
  j.number("longest_loss_s", longest_loss_s_);
}

}  // namespace sinew::plant
