#include "apps/run/tilt_error.hpp"

#include <algorithm>
#include <cmath>

#include "math/elementary.hpp"
#include "math/linear.hpp"

namespace sinew::app {

double tilt_error_rad(const msg::Quat& q_true, const msg::Quat& q_estimated) {
  const math::Vec3 up{0, 0, 1};
  const math::Vec3 a = math::Quat(q_true).conjugate().rotate(up);
  const math::Vec3 b = math::Quat(q_estimated).conjugate().rotate(up);
  return math::atan2(math::norm(math::cross(a, b)), math::dot(a, b));
}

TiltErrors summarise(std::vector<std::pair<double, double>> over_time, double settle_s) {
  TiltErrors result;
  double sum = 0;
  for (const auto& [t, deg] : over_time) {
    if (t < settle_s) continue;
    sum += deg * deg;
    result.max_deg = std::max(result.max_deg, deg);
    ++result.compared;
  }
  if (result.compared > 0) result.rms_deg = std::sqrt(sum / static_cast<double>(result.compared));
  result.over_time = std::move(over_time);
  return result;
}

}  // namespace sinew::app
