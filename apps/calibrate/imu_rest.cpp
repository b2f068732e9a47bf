#include "apps/calibrate/imu_rest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace sinew::app {
namespace {

// On a table: MEMS noise at 1 kHz is below a tenth of this, a hand that holds the IMU above.
constexpr double kStillGyro_radps = 0.05, kStillAccel_mps2 = 0.5;
constexpr double kTurningGyro_radps = 0.35;  // 20 deg/s: no MEMS gyro has such a bias
constexpr double kSkewed = 0.2;              // share of gravity, across the vertical axis

}  // namespace

void ImuRest::add(const msg::ImuSample& s) {
  const std::array<double, 6> x{s.gyro_radps.x, s.gyro_radps.y, s.gyro_radps.z,
                                s.accel_mps2.x, s.accel_mps2.y, s.accel_mps2.z};
  ++count_;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double from_old = x[i] - mean_[i];
    mean_[i] += from_old / static_cast<double>(count_);
    squares_[i] += from_old * (x[i] - mean_[i]);
  }
}

double ImuRest::spread(std::size_t first) const {
  if (count_ < 2) return 0;
  const double most = std::max({squares_[first], squares_[first + 1], squares_[first + 2]});
  return std::sqrt(most / static_cast<double>(count_ - 1));
}

std::string ImuRest::moved() const {
  if (gyro_spread_radps() > kStillGyro_radps)
    return fmt::format("it moved: the rates spread by {:.3f} rad/s (at rest below {})", gyro_spread_radps(),
                       kStillGyro_radps);
  if (accel_spread_mps2() > kStillAccel_mps2)
    return fmt::format("it was shaken: the accelerations spread by {:.3f} m/s^2 (at rest below {})",
                       accel_spread_mps2(), kStillAccel_mps2);
  for (std::size_t i = 0; i < 3; ++i)
    if (std::abs(mean_[i]) > kTurningGyro_radps)
      return fmt::format("it turned: {:.3f} rad/s about {} (a bias is below {})", mean_[i], "xyz"[i],
                         kTurningGyro_radps);
  return {};
}

std::optional<AccelCalibration> six_positions(const std::vector<msg::Vec3>& means, double gravity_mps2,
                                              std::string& why) {
  std::array<std::array<std::optional<double>, 2>, 3> seen{};  // axis; down, up
  for (const msg::Vec3& m : means) {
    const std::array<double, 3> v{m.x, m.y, m.z};
    const auto axis = static_cast<std::size_t>(
        std::max_element(v.begin(), v.end(), [](double a, double b) { return std::abs(a) < std::abs(b); }) - v.begin());
    const bool up = v[axis] > 0;
    const std::string position = fmt::format("{} {}", "xyz"[axis], up ? "up" : "down");
    for (std::size_t other = 0; other < 3; ++other)
      if (other != axis && std::abs(v[other]) > kSkewed * gravity_mps2) {
        why = fmt::format("{}: it did not lie flat: {:.2f} m/s^2 along {}", position, v[other], "xyz"[other]);
        return std::nullopt;
      }
    if (seen[axis][up]) {
      why = position + ": this position was there already";
      return std::nullopt;
    }
    seen[axis][up] = v[axis];
  }
  AccelCalibration c;
  const std::array<double*, 3> bias{&c.bias_mps2.x, &c.bias_mps2.y, &c.bias_mps2.z};
  const std::array<double*, 3> scale{&c.scale.x, &c.scale.y, &c.scale.z};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const bool up : {false, true})
      if (!seen[axis][up]) {
        why = fmt::format("{} {}: this position is missing", "xyz"[axis], up ? "up" : "down");
        return std::nullopt;
      }
    *bias[axis] = (*seen[axis][1] + *seen[axis][0]) / 2;
    *scale[axis] = 2 * gravity_mps2 / (*seen[axis][1] - *seen[axis][0]);
  }
  return c;
}

}  // namespace sinew::app
