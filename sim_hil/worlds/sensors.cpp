#include "sim_hil/worlds/sensors.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sinew::plant {

ImuModel::ImuModel(const ImuErrors& errors, std::uint64_t seed) : e_(errors), noise_(seed, 0x696d75) {
  for (int i = 0; i < 3; ++i) {
    gyro_bias_[i] = e_.gyro_bias_radps * noise_.normal();
    accel_bias_[i] = e_.accel_bias_mps2 * noise_.normal();
    gyro_scale_[i] = 1.0 + e_.scale * noise_.normal();
    accel_scale_[i] = 1.0 + e_.scale * noise_.normal();
  }
}

msg::ImuSample ImuModel::measure(const msg::Vec3& gyro_radps, const msg::Vec3& accel_mps2, double vibration,
                                 double dt_s) {
  const double gyro_in[3] = {gyro_radps.x, gyro_radps.y, gyro_radps.z};
  const double accel_in[3] = {accel_mps2.x, accel_mps2.y, accel_mps2.z};
  const double root_dt = std::sqrt(dt_s);
  const double shake = e_.vibration_mps2 * vibration;
  const double accel_sigma = std::sqrt(e_.accel_noise_mps2 * e_.accel_noise_mps2 + shake * shake);
  double gyro[3], accel[3];
  for (int i = 0; i < 3; ++i) {
    gyro_bias_[i] += e_.gyro_walk * root_dt * noise_.normal();
    accel_bias_[i] += e_.accel_walk * root_dt * noise_.normal();
    gyro[i] = gyro_scale_[i] * gyro_in[i] + gyro_bias_[i] + e_.gyro_noise_radps * noise_.normal();
    accel[i] = accel_scale_[i] * accel_in[i] + accel_bias_[i] + accel_sigma * noise_.normal();
  }
  msg::ImuSample s;
  s.gyro_radps = {gyro[0], gyro[1], gyro[2]};
  s.accel_mps2 = {accel[0], accel[1], accel[2]};
  return s;
}

double RangeModel::measure(double true_m) {
  const double noise = noise_.normal();  // always drawn, so that the stream does not depend on the range
  if (!(true_m >= e_.min_m && true_m <= e_.max_m)) return std::numeric_limits<double>::quiet_NaN();
  return true_m + (e_.noise_m + e_.noise_share * true_m) * noise;
}

BaroModel::BaroModel(const BaroErrors& errors, std::uint64_t seed) : e_(errors), noise_(seed, 0x6261726f) {
  drift_pa_ = 150.0 * noise_.uniform(-1, 1);  // the weather of the day
}

msg::BaroSample BaroModel::measure(double height_m, double wash, double dt_s) {
  drift_pa_ += e_.walk_pa * std::sqrt(dt_s) * noise_.normal();
  const double x = height_m / 8640.0;  // scale height at 22 degC; the series of exp() is exact enough in a room
  msg::BaroSample s;
  s.pressure_pa =
      e_.sea_level_pa * (1.0 - x + 0.5 * x * x) + drift_pa_ + e_.wash_pa * wash + e_.noise_pa * noise_.normal();
  s.temperature_c = e_.temperature_c;
  return s;
}

BatteryModel::BatteryModel(const BatteryErrors& errors, std::uint64_t seed)
    : e_(errors),
      noise_(seed, 0x62617474),
      voltage_scale_(1.0 + e_.voltage_scale * noise_.normal()),
      current_scale_(1.0 + e_.current_scale * noise_.normal()),
      charge_offset_(e_.charge_offset * noise_.normal()) {}

msg::BatterySample BatteryModel::measure(double voltage_v, double current_a, double charge) {
  msg::BatterySample s;
  s.voltage_v = voltage_scale_ * voltage_v + e_.voltage_noise_v * noise_.normal();
  s.current_a = current_scale_ * current_a + e_.current_noise_a * noise_.normal();
  s.charge = std::clamp(charge + charge_offset_, 0.0, 1.0);
  return s;
}

}  // namespace sinew::plant
