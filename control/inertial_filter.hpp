#pragma once
#include <span>

#include "control/covariance.hpp"

namespace sinew::control {

/// What the filter believes. World: z up. The surroundings count outdoors only (InertialFilter::open_surroundings()).
struct InertialState {
  math::Quat q_world_base;
  math::Vec3 p_world_m, v_world_mps;
  math::Vec3 gyro_bias_radps, accel_bias_mps2;
  math::Vec3 earth_field_t;   // world: what a magnetometer would read far from the vehicle's own iron
  math::Vec3 body_field_t;    // base: what the vehicle adds to it
  math::Vec3 wind_world_mps;  // horizontal; z is 0
};

/// Densities of white noise and of the walk of the biases.
struct InertialNoise {
  double gyro = 4.0e-4;            // rad/s per root hertz
  double accel = 1.5e-2;           // m/s^2 per root hertz
  double gyro_walk = 8.0e-5;       // rad/s per root second
  double accel_walk = 1.0e-3;      // m/s^2 per root second
  double earth_field_walk = 5e-8;  // T per root second
  double body_field_walk = 2e-8;   // likewise
  double wind_walk = 0.1;          // m/s per root second
};

/// Standard deviations of the states at the start.
struct InertialSpread {
  double tilt_rad = 0.12, yaw_rad = 0.01;
  double v_mps = 2.0, p_m = 0.01;
  double gyro_bias_radps = 0.06, accel_bias_mps2 = 0.25;
};

inline constexpr double kGravity = 9.81;
inline constexpr double kNoGate = 1e18;  // for update(): a measurement that is used whatever it says

/// Error-state Kalman filter of 15 states, outdoors of 23 (Sola 2017, "Quaternion kinematics for the error-state Kalman
/// filter", with the attitude error in world axes). It knows inertial motion and scalar measurements; NavEstimator
/// knows the sensors. Thread:  owner.   RT: yes.
class InertialFilter {
 public:
  void start(const InertialState& state, const InertialSpread& spread);
  /// One inertial sample that held for `dt_s`.
  void predict(const math::Vec3& gyro_radps, const math::Vec3& accel_mps2, double dt_s, const InertialNoise& noise);
  /// Scalar measurements of one instant, one after the other. A measurement whose squared normalised innovation exceeds
  /// `gate` is left out. Returns how many were used.
  std::uint32_t update(std::span<const Measurement> measurements, double gate);

  /// From now on the surroundings are states, too: their values, and one sigma of each component.
  void open_surroundings(const InertialState& values, double earth_field_t, double body_field_t, double wind_mps);
  /// The same surroundings anew, without correlations.
  void reset_earth_field(const math::Vec3& field_t, double sigma_t);
  void reset_body_field(const math::Vec3& field_t, double sigma_t);

  const InertialState& state() const { return x_; }
  const Covariance& covariance() const { return p_; }
  /// Sets one axis of the position and forgets its correlations.
  void reset_position(int axis, double p_m, double variance);
  void reset_velocity(int axis, double v_mps, double variance);
  /// Turns the whole world under the vehicle by `angle_rad` about the vertical through the origin: position, velocity,
  /// attitude, earth field, wind and their covariances. Nothing measured changes; only the axes do.
  void turn_world(double angle_rad);
  /// Turns the vehicle by `angle_rad` about the vertical, keeps position and velocity, and forgets what was known about
  /// the heading.
  void reset_yaw(double angle_rad, double variance);
  /// Forgets one axis of the velocity likewise, but keeps its value until it is measured anew.
  void reopen_velocity(int axis, double variance) { p_.reopen(kErrV + axis, variance); }
  /// Specific force of the last sample in world axes, without bias.
  const math::Vec3& f_world_mps2() const { return f_world_; }

 private:
  void inject(const ErrorVector& dx);
  InertialState x_;
  math::Vec3 f_world_;
  Covariance p_;  // aligned to 16; with the two above no padding
};

}  // namespace sinew::control
