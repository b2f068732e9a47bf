#include "control/attitude_law.hpp"

#include "control/limits.hpp"

namespace sinew::control {

void AttitudeLaw::reset() {
  integral_radps2_ = accel_filtered_ = gyro_before_ = {};
  has_gyro_ = 0;
}

math::Vec3 AttitudeLaw::rate_setpoint(const math::Quat& q, const math::Quat& wanted) const {
  const math::Vec3 up{0, 0, 1};
  const math::Vec3 up_wanted = q.conjugate().rotate(wanted.rotate(up));  // in base axes
  const math::Quat tilt = math::Quat::between(up, up_wanted);
  const math::Vec3 turn = tilt.log();  // about an axis normal to base z
  // What is left after the tilt is a turn about base z.
  const math::Quat rest = tilt.conjugate() * (q.conjugate() * wanted);
  const double yaw = rest.log().z;
  math::Vec3 rate{params.kp_tilt * turn.x, params.kp_tilt * turn.y, 0};
  rate = limit_horizontal(rate, params.rate_tilt_radps);
  rate.z = clamp(params.kp_yaw * yaw, -params.rate_yaw_radps, params.rate_yaw_radps);
  return rate;
}

msg::WrenchSetpoint AttitudeLaw::step(const msg::NavState& nav, const msg::AttitudeSetpoint& wanted, double dt_s) {
  msg::WrenchSetpoint out;
  out.stamp = nav.stamp;
  out.armed = wanted.armed;
  if (!wanted.armed) {
    reset();
    return out;
  }
  const math::Vec3 gyro(nav.gyro_radps);
  if (has_gyro_ != 0) {
    const double turn = 2 * math::kPi * params.d_cutoff_hz * dt_s;
    accel_filtered_ += ((gyro - gyro_before_) / dt_s - accel_filtered_) * (turn / (1 + turn));
  }
  gyro_before_ = gyro;
  has_gyro_ = 1;
  if (wanted.thrust_n <= 0) {  // motors idle on the ground: nothing to turn, nothing to sum up
    integral_radps2_ = {};
    return out;
  }
  const math::Vec3 error = rate_setpoint(math::Quat(nav.q_world_base), math::Quat(wanted.q_world_base)) - gyro;
  const auto axis = [&](int i, double kp, double ki, double limit) {
    integral_radps2_[i] = clamp(integral_radps2_[i] + ki * error[i] * dt_s, -limit, limit);
    return kp * error[i] + integral_radps2_[i] - params.kd_rate * accel_filtered_[i];
  };
  const math::Vec3 accel{axis(0, params.kp_rate, params.ki_rate, params.integral_radps2),
                         axis(1, params.kp_rate, params.ki_rate, params.integral_radps2),
                         axis(2, params.kp_rate_yaw, params.ki_rate_yaw, params.integral_yaw_radps2)};
  const math::Vec3& j = params.inertia_kgm2;
  const math::Vec3 spin{j.x * gyro.x, j.y * gyro.y, j.z * gyro.z};
  const math::Vec3 torque = math::Vec3{j.x * accel.x, j.y * accel.y, j.z * accel.z} + cross(gyro, spin);
  out.torque_nm = torque.to<msg::Vec3>();
  out.thrust_n = wanted.thrust_n;
  return out;
}

}  // namespace sinew::control
