#include "motion/fall.hpp"

namespace sinew::motion {

void FallDetector::step(const math::Vec3& up, const math::Vec3& rate_radps, double dt_s) {
  rate_ += (rate_radps - rate_) * (dt_s / (dt_s + params.smooth_s));
  // Past 90 degrees the angles of a fall go on.
  const double forward = math::atan2(-up.x, up.z), left = -math::atan2(up.y, up.z);
  forward_rad_ = forward + rate_.y / params.omega_radps;
  left_rad_ = left - rate_.x / params.omega_radps;
  FallWay way = FallWay::none;
  // A body that stands still again in spite of its tilt does not fall: both have to go the same way.
  if (forward > 0 && forward_rad_ > params.pitch_front_rad) way = FallWay::front;
  if (forward < 0 && forward_rad_ < -params.pitch_back_rad) way = FallWay::back;
  if (left > 0 && left_rad_ > params.roll_rad) way = FallWay::left;
  if (left < 0 && left_rad_ < -params.roll_rad) way = FallWay::right;
  beyond_s_ = way == FallWay::none ? 0 : beyond_s_ + dt_s;
  if (way_ != FallWay::none && !gives_way()) {
    told_s_ += dt_s;
    if (way == FallWay::none) way_ = FallWay::none;
  } else if (way_ == FallWay::none && beyond_s_ > params.hold_s) {
    way_ = way;
    told_s_ = 0;
  }

  const bool lies = up.z < math::cos(params.lying_rad);
  rest_s_ = norm(rate_) < params.rest_radps ? rest_s_ + dt_s : 0;
  still_s_ = lies && rest_s_ > 0 ? still_s_ + dt_s : 0;
}

FallWay lying(const math::Vec3& up) {
  if (up.z > 0.5) return FallWay::none;
  if (math::fabs(up.x) >= math::fabs(up.y)) return up.x < 0 ? FallWay::front : FallWay::back;
  return up.y > 0 ? FallWay::right : FallWay::left;
}

}  // namespace sinew::motion
