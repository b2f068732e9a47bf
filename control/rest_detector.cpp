#include "control/rest_detector.hpp"

namespace sinew::control {
namespace {

math::Vec3 squares(const math::Vec3& v) { return {v.x * v.x, v.y * v.y, v.z * v.z}; }

double largest(const math::Vec3& v) {
  const double x = math::fabs(v.x), y = math::fabs(v.y), z = math::fabs(v.z);
  return x > y ? (x > z ? x : z) : (y > z ? y : z);
}

}  // namespace

bool RestDetector::add(const math::Vec3& gyro_radps, const math::Vec3& accel_mps2, double dt_s, const Params& p) {
  // Sums of differences from the last mean, so that nothing large cancels in the variance.
  const math::Vec3 g = gyro_radps - gyro_mean_, a = accel_mps2 - accel_mean_;
  sums_.gyro += g;
  sums_.accel += a;
  sums_.gyro2 += squares(g);
  sums_.accel2 += squares(a);
  sums_.n += 1;
  sums_.time_s += dt_s;
  if (sums_.time_s < p.block_s) return false;

  const math::Vec3 gyro_step = sums_.gyro / sums_.n, accel_step = sums_.accel / sums_.n;
  const double gyro_variance = largest(sums_.gyro2 / sums_.n - squares(gyro_step));
  const double accel_variance = largest(sums_.accel2 / sums_.n - squares(accel_step));
  gyro_mean_ += gyro_step;
  accel_mean_ += accel_step;
  sums_ = {};
  const bool calm = gyro_variance < p.gyro_spread_radps * p.gyro_spread_radps &&
                    accel_variance < p.accel_spread_mps2 * p.accel_spread_mps2 &&
                    largest(gyro_mean_) < p.gyro_mean_radps;
  const bool rests =
      calm && quiet_ != 0 && largest(gyro_step) < p.gyro_step_radps && largest(accel_step) < p.accel_step_mps2;
  at_rest_ = rests ? at_rest_ + 1 : 0;
  quiet_ = calm;
  return rests;
}

}  // namespace sinew::control
