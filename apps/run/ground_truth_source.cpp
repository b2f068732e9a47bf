#include "apps/run/ground_truth_source.hpp"

#include <limits>

namespace sinew::app {

void GroundTruthSource::play(std::vector<msg::NavState> states) {
  states_ = std::move(states);
  plays_.store(true, std::memory_order_release);
}

void GroundTruthSource::collect(rt::Time now) noexcept {
  if (!plays_.load(std::memory_order_acquire)) return;
  while (next_ < states_.size() && states_[next_].stamp <= now) {
    msg::NavState* const to = state_.loan();
    if (!to) return;
    *to = states_[next_++];
  }
}

msg::NavState true_state(const dataset::GroundTruthSample& sample, rt::Time stamp) {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  constexpr msg::Vec3 kNowhere{kUnknown, kUnknown, kUnknown};
  msg::NavState state;
  state.stamp = stamp;
  state.q_world_base = sample.q_world_base;
  state.v_world_mps = sample.v_world_mps;
  state.p_world_m = sample.p_world_m;
  state.gyro_bias_radps = sample.gyro_bias_radps;
  state.accel_bias_mps2 = sample.accel_bias_mps2;
  state.gyro_radps = kNowhere;
  state.pad_world_m = kNowhere;
  state.height_m = state.tilt_std_rad = state.p_std_m = state.v_std_mps = kUnknown;
  state.attitude_valid = state.position_valid = 1;
  return state;
}

}  // namespace sinew::app
