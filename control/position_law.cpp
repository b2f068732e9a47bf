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

math::Vec3 PositionLaw::wished_acceleration(const math::Vec3& e, const msg::NavState& nav) const {
  math::Vec3 wish = integral_mps2_;
  if (nav.position_valid) wish += math::Vec3{params.kv_xy * e.x, params.kv_xy * e.y, 0};
  if (nav.height_valid) {
    wish.z += params.kv_z * e.z;
  } else {
    wish.z = (kGravity + integral_mps2_.z) * params.blind_thrust_share - kGravity;
  }
  return wish;
}

/// A limit that is reached freezes the integrals that push into it.
void PositionLaw::integrate(const math::Vec3& e, const math::Vec3& frozen, double dt_s) {
  const double ki[3] = {params.ki_xy, params.ki_xy, params.ki_z};
  const double limit[3] = {params.integral_xy_mps2, params.integral_xy_mps2, params.integral_z_mps2};
  for (int i = 0; i < 3; ++i) {
    if (frozen[i] > 0 && integral_mps2_[i] * e[i] > 0) continue;
    integral_mps2_[i] = clamp(integral_mps2_[i] + ki[i] * e[i] * dt_s, -limit[i], limit[i]);
  }
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
  const math::Vec3 error = velocity_setpoint(nav, wanted) - math::Vec3(nav.v_world_mps);
  const math::Vec3 wish = wished_acceleration(error, nav);

  // Vertical first: height has priority over place.
  const double fz = params.mass_kg * (kGravity + wish.z);
  const double fz_limited = clamp(fz, params.thrust_min_n, params.thrust_max_n);
  const math::Vec3 sideways{params.mass_kg * wish.x, params.mass_kg * wish.y, 0};
  math::Vec3 force = limit_horizontal(sideways, fz_limited * math::tan(params.tilt_rad));
  const bool wide = !(force == sideways);
  force.z = fz_limited;
  const double xy_frozen = wide ? 1 : 0, z_frozen = fz != fz_limited ? 1 : 0;
  if (nav.position_valid) integrate(error, {xy_frozen, xy_frozen, z_frozen}, dt_s);

  out.q_world_base = attitude_of(force, wanted.yaw_rad).to<msg::Quat>();
  const math::Vec3 up = q.rotate({0, 0, 1});  // what the present thrust direction can give along the wanted force
  out.thrust_n = clamp(dot(force, up), params.thrust_min_n, params.thrust_max_n);
  return out;
}

}  // namespace sinew::control
