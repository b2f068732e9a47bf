#pragma once
#include "math/linear.hpp"
#include "msg/flight.hpp"

namespace sinew::control {

/// Numbers of attitude and rate loop; the module AttitudeController gives each its range.
struct AttitudeParams {
  double kp_tilt = 7.0, kp_yaw = 2.5;  // 1/s: angle error to rate
  double rate_tilt_radps = 4.0, rate_yaw_radps = 1.5;
  double kp_rate = 22.0, kp_rate_yaw = 6.0;  // 1/s: rate error to angular acceleration
  double ki_rate = 20.0, ki_rate_yaw = 4.0;  // 1/s^2
  double kd_rate = 0.35;                     // damping by the body's angular acceleration, filtered
  double d_cutoff_hz = 60;
  double integral_radps2 = 25.0, integral_yaw_radps2 = 4.0;
  math::Vec3 inertia_kgm2{0.011, 0.0112, 0.020};
};

/// Attitude to torque: the shortest turn of the thrust axis first, yaw with less force; then rates with proportional
/// and integral part and damping from the filtered change of the measured rate.
/// Frames:  base; positive torque turns counter-clockwise about its axis.
/// Thread:  owner.   RT: yes.
class AttitudeLaw {
 public:
  AttitudeParams params;

  void reset();
  msg::WrenchSetpoint step(const msg::NavState& nav, const msg::AttitudeSetpoint& wanted, double dt_s);
  /// The body rate that the attitude error asks for; for tests and monitoring.
  math::Vec3 rate_setpoint(const math::Quat& q_world_base, const math::Quat& wanted) const;

 private:
  math::Vec3 integral_radps2_, gyro_before_, accel_filtered_;
  std::uint64_t has_gyro_ = 0;  // a bool would leave padding in a state
};

}  // namespace sinew::control
