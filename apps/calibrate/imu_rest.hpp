#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "msg/sensors.hpp"

namespace sinew::app {

/// What an IMU measured while it lay still, in its own axes.
/// Source of the running mean and variance: B. P. Welford, Technometrics 4 (1962).
class ImuRest {
 public:
  void add(const msg::ImuSample& sample);
  std::size_t count() const { return count_; }
  msg::Vec3 gyro_mean_radps() const { return mean(0); }
  msg::Vec3 accel_mean_mps2() const { return mean(3); }
  /// Largest standard deviation of an axis.
  double gyro_spread_radps() const { return spread(0); }
  double accel_spread_mps2() const { return spread(3); }
  /// Empty: it lay still; else the value that shows a motion.
  std::string moved() const;

 private:
  msg::Vec3 mean(std::size_t first) const { return {mean_[first], mean_[first + 1], mean_[first + 2]}; }
  double spread(std::size_t first) const;
  std::size_t count_ = 0;
  std::array<double, 6> mean_{}, squares_{};
};

struct AccelCalibration {
  msg::Vec3 bias_mps2, scale{1, 1, 1};
};

/// Bias and scale of each axis from means at rest, in which each axis has pointed up once and down once (in any order;
/// the largest axis of a mean is the one that pointed).
/// Nothing: `why` says which position is missing, was there twice, or cannot be this IMU's.
std::optional<AccelCalibration> six_positions(const std::vector<msg::Vec3>& means, double gravity_mps2,
                                              std::string& why);

}  // namespace sinew::app
