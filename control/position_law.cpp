#include "control/position_law.hpp"

#include "control/inertial_filter.hpp"
#include "control/limits.hpp"

namespace sinew::control {
namespace {

math::Quat attitude_of(const math::Vec3& force, double yaw_rad) {
  return math::Quat::between({0, 0, 1}, force) * math::Quat::from_axis_angle({0, 0, 1}, yaw_rad);
}

}  // namespace

math::Vec3 PositionLaw::velocity_setpoint(const msg::NavState& nav, const msg::FlightSetpoint& wanted) const {
  math::Vec3 v(wanted.v_world_mps);
  if (wanted.mode == msg::FlightMode::position) {
    const math::Vec3 away = math::Vec3(wanted.p_world_m) - math::Vec3(nav.p_world_m);
    v += math::Vec3{params.kp_xy * away.x, params.kp_xy * away.y, params.kp_z * away.z};
  }
  v = limit_horizontal(v, params.speed_xy_mps);
  v.z = clamp(v.z, -params.sink_mps, params.climb_mps);
  return v;
}

msg::AttitudeSetpoint PositionLaw::step(const msg::NavState& nav, const msg::FlightSetpoint& wanted, double dt_s) {
  msg::AttitudeSetpoint out;
  out.stamp = nav.stamp;
  out.armed = wanted.armed;
  const math::Quat q(nav.q_world_base);
  if (!wanted.armed || wanted.mode == msg::FlightMode::idle) {
    reset();
    out.q_world_base = math::Quat::from_axis_angle({0, 0, 1}, q.yaw()).to<msg::Quat>();
    return out;
  }
  if (!nav.position_valid) {  // level and a little too light: the only thing left is to come down upright
    reset();
    out.q_world_base = math::Quat::from_axis_angle({0, 0, 1}, q.yaw()).to<msg::Quat>();
    out.thrust_n = params.blind_thrust_share * params.mass_kg * kGravity;
    return out;
  }
  const math::Vec3 error = velocity_setpoint(nav, wanted) - math::Vec3(nav.v_world_mps);
  const math::Vec3 wish{params.kv_xy * error.x + integral_mps2_.x, params.kv_xy * error.y + integral_mps2_.y,
                        params.kv_z * error.z + integral_mps2_.z};

  // Vertical first: height is held before the place is.
  const double force_max = params.thrust_max_n, force_min = params.thrust_min_n;
  const double fz = params.mass_kg * (kGravity + wish.z);
  const double fz_limited = clamp(fz, force_min, force_max);
  const double sideways_max = fz_limited * math::tan(params.tilt_rad);
  const math::Vec3 sideways = limit_horizontal({params.mass_kg * wish.x, params.mass_kg * wish.y, 0}, sideways_max);
  const math::Vec3 force{sideways.x, sideways.y, fz_limited};

  // A limit that is reached freezes the integrals that push into it.
  const bool wide = sideways.x != params.mass_kg * wish.x || sideways.y != params.mass_kg * wish.y;
  const auto integrate = [dt_s](double& sum, double ki, double e, bool stuck, double limit) {
    if (stuck && sum * e > 0) return;
    sum = clamp(sum + ki * e * dt_s, -limit, limit);
  };
  integrate(integral_mps2_.x, params.ki_xy, error.x, wide, params.integral_xy_mps2);
  integrate(integral_mps2_.y, params.ki_xy, error.y, wide, params.integral_xy_mps2);
  integrate(integral_mps2_.z, params.ki_z, error.z, fz != fz_limited, params.integral_z_mps2);

  out.q_world_base = attitude_of(force, wanted.yaw_rad).to<msg::Quat>();
  const math::Vec3 up = q.rotate({0, 0, 1});  // what the thrust of now can give along the wanted force
  out.thrust_n = clamp(dot(force, up), force_min, force_max);
  return out;
}

}  // namespace sinew::control
