#pragma once
#include <utility>
#include <vector>

#include "msg/flight.hpp"
#include "msg/geometry.hpp"

namespace sinew::app {

/// Angle between true and estimated "up", both seen from the body. Both quaternions take base to world.
double tilt_error_rad(const msg::Quat& q_true, const msg::Quat& q_estimated);

struct TiltErrors {
  std::vector<std::pair<double, double>> over_time;  // s since the first estimate, deg
  double rms_deg = 0, max_deg = 0;                   // from `settle_s` on
  std::size_t compared = 0;                          // estimates that the two figures rest on
};

/// `truth(estimate, q)` writes the true attitude at the estimate's instant; false where there is none.
template <class Truth>
TiltErrors tilt_errors(const std::vector<msg::NavState>& estimates, double settle_s, Truth truth);

/// The same errors, from pairs of time (s) and error (deg).
TiltErrors summarise(std::vector<std::pair<double, double>> over_time, double settle_s);

template <class Truth>
TiltErrors tilt_errors(const std::vector<msg::NavState>& estimates, double settle_s, Truth truth) {
  std::vector<std::pair<double, double>> errors;
  for (const auto& e : estimates) {
    msg::Quat q;
    if (!e.attitude_valid || !truth(e, q)) continue;
    errors.emplace_back(msg::seconds(e.stamp - estimates.front().stamp),
                        tilt_error_rad(q, e.q_world_base) * 57.29577951308232);
  }
  return summarise(std::move(errors), settle_s);
}

}  // namespace sinew::app
