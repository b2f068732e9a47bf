#pragma once
#include "math/linear.hpp"

namespace sinew::control {

/// Tells from the inertial samples alone whether the vehicle stands still: it looks at blocks of samples and compares
/// their spread with what only a stopped vehicle shows. A hovering one shakes.
/// Thread:  owner.   RT: yes.
class RestDetector {
 public:
  struct Params {
    double block_s = 0.2;
    double gyro_spread_radps = 0.015;  // largest standard deviation of an axis in a block
    double accel_spread_mps2 = 0.15;
    double gyro_mean_radps = 0.15;  // largest mean: the worst bias
    double accel_step_mps2 = 0.05;  // largest change of the mean from block to block
    double gyro_step_radps = 0.004;
  };

  void reset() { *this = RestDetector{}; }
  /// True when this sample ends a block at rest and the block before was at rest, too; mean() is then valid.
  bool add(const math::Vec3& gyro_radps, const math::Vec3& accel_mps2, double dt_s, const Params& params);
  bool at_rest() const { return at_rest_ != 0; }
  std::uint32_t blocks_at_rest() const { return at_rest_; }  // one after the other
  const math::Vec3& gyro_mean_radps() const { return gyro_mean_; }
  const math::Vec3& accel_mean_mps2() const { return accel_mean_; }

 private:
  struct Sums {
    math::Vec3 gyro, accel, gyro2, accel2;
    double n = 0, time_s = 0;
  };
  Sums sums_;
  math::Vec3 gyro_mean_, accel_mean_;
  std::uint32_t quiet_ = 0, at_rest_ = 0;  // quiet_: 0 or 1; a bool would leave padding in a state
};

}  // namespace sinew::control
