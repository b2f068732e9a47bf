#pragma once
// Errors of the sensors: they turn true values into what the robot gets.
#include "math/random.hpp"
#include "msg/sensors.hpp"

namespace sinew::plant {

/// A MEMS unit on a vibrating frame (figures as in the data sheets of the ICM-20602 class, noise at 1 kHz).
struct ImuErrors {
  double gyro_noise_radps = 0.004, accel_noise_mps2 = 0.06;
  double vibration_mps2 = 0.5;                            // sigma at full rotor speed, on top
  double gyro_bias_radps = 0.01, accel_bias_mps2 = 0.08;  // sigma, drawn once
  double gyro_walk = 1.0e-4, accel_walk = 1.0e-3;         // per root second
  double scale = 0.003;                                   // sigma, drawn once per axis
};

class ImuModel {
 public:
  ImuModel(const ImuErrors& errors, std::uint64_t seed);
  /// `vibration` in 0..1 is the share of full rotor speed.
  msg::ImuSample measure(const msg::Vec3& gyro_radps, const msg::Vec3& accel_mps2, double vibration, double dt_s);

 private:
  ImuErrors e_;
  math::Random noise_;
  double gyro_bias_[3], accel_bias_[3], gyro_scale_[3], accel_scale_[3];
};

/// A time-of-flight range finder.
struct RangeErrors {
  double noise_m = 0.004, noise_share = 0.003;  // sigma = noise_m + noise_share * range
  double min_m = 0.02, max_m = 6.0;             // outside: NaN
};

class RangeModel {
 public:
  RangeModel(const RangeErrors& errors, std::uint64_t seed) : e_(errors), noise_(seed, 0x72616e67) {}
  /// `true_m` is negative when the beam hits nothing.
  double measure(double true_m);

 private:
  RangeErrors e_;
  math::Random noise_;
};

struct BaroErrors {
  double sea_level_pa = 101325.0, temperature_c = 22.0;
  double noise_pa = 2.0;  // about 0.17 m
  double walk_pa = 0.8;   // per root second: weather, doors, warming-up
  double wash_pa = 6.0;   // pressure of the rotors' own wash at full speed
};

class BaroModel {
 public:
  BaroModel(const BaroErrors& errors, std::uint64_t seed);
  /// Sets pressure and temperature; `wash` in 0..1 is the share of full rotor speed, squared.
  msg::BaroSample measure(double height_m, double wash, double dt_s);

 private:
  BaroErrors e_;
  math::Random noise_;
  double drift_pa_ = 0;
};

/// A power module with a coulomb counter.
struct BatteryErrors {
  double voltage_noise_v = 0.02, voltage_scale = 0.005;  // scales: sigma, drawn once
  double current_noise_a = 0.2, current_scale = 0.02;
  double charge_offset = 0.02;  // sigma, drawn once: the counter's error when it was switched on
};

class BatteryModel {
 public:
  BatteryModel(const BatteryErrors& errors, std::uint64_t seed);
  msg::BatterySample measure(double voltage_v, double current_a, double charge);

 private:
  BatteryErrors e_;
  math::Random noise_;
  double voltage_scale_, current_scale_, charge_offset_;
};

}  // namespace sinew::plant
