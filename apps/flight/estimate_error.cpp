#include "apps/flight/estimate_error.hpp"

#include <algorithm>
#include <cmath>

namespace sinew::app {
namespace {

double yaw_of(const msg::Quat& q) { return std::atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z)); }

}  // namespace

void EstimateError::add(const msg::NavState& estimate, const msg::NavState& truth) {
  if (!estimate.attitude_valid || !estimate.position_valid) return;
  if (pairs_++ == 0) {
    estimate_ = estimate;
    truth_ = truth;
    const double turn_rad = yaw_of(estimate.q_world_base) - yaw_of(truth.q_world_base);
    cos_ = std::cos(turn_rad), sin_ = std::sin(turn_rad);
  }
  const double x = truth.p_world_m.x - truth_.p_world_m.x, y = truth.p_world_m.y - truth_.p_world_m.y;
  const double off_x = estimate.p_world_m.x - estimate_.p_world_m.x - (cos_ * x - sin_ * y);
  const double off_y = estimate.p_world_m.y - estimate_.p_world_m.y - (sin_ * x + cos_ * y);
  result_.last_m = std::hypot(off_x, off_y);
  result_.worst_m = std::max(result_.worst_m, result_.last_m);
}

}  // namespace sinew::app
