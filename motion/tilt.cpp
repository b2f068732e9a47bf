#include "motion/tilt.hpp"

#include <algorithm>

namespace sinew::motion {

namespace {
constexpr double kUpright_mps2 = 9.81;
}

void Tilt::start(const math::Vec3& accel_mps2) {
  q_ = norm(accel_mps2) > 1 ? math::Quat::between(accel_mps2, {0, 0, 1}) : math::Quat{};
  rate_ = {};
}

void Tilt::step(const math::Vec3& gyro_radps, const math::Vec3& accel_mps2, bool at_rest, double dt_s) {
  if (at_rest && norm(gyro_radps) < params.rest_radps) {
    // Only yaw has no other source. Its mean waits until the robot has settled on its feet, which turns it.
    const math::Vec3 wrong = gyro_radps - bias_, about_up = dot(wrong, up()) * up();
    bias_ += (wrong - about_up) * (params.rest_per_s * dt_s);
    rest_s_ += dt_s;
    if (rest_s_ > params.settle_s) {
      learned_s_ = std::min(learned_s_ + dt_s, params.rest_memory_s);
      bias_ += about_up * (dt_s / learned_s_);
    }
  } else {
    rest_s_ = 0;
  }
  rate_ = gyro_radps - bias_;
  math::Vec3 error;  // torso axes: rotates the believed up to the measured one
  if (norm(accel_mps2) < params.most_mps2) error = cross(accel_mps2 / kUpright_mps2, up());
  // The draw takes all of it: it is perpendicular to the vertical and turns no heading, which its part along x and y
  // alone would. What is learned takes none along z: its mean there is what sway and nodding have in common.
  bias_ -= math::Vec3{error.x, error.y, 0} * (params.bias_per_s2 * dt_s);
  for (int i = 0; i < 3; ++i) bias_[i] = std::clamp(bias_[i], -params.most_bias_radps, params.most_bias_radps);
  q_ = (q_ * math::Quat::exp((rate_ + params.accel_per_s * error) * dt_s)).normalized();
}

}  // namespace sinew::motion
