#include "control/inertial_filter.hpp"

namespace sinew::control {
namespace {

/// One Newton step towards length 1: enough after a small rotation, and no square root.
math::Quat nearly_normalized(const math::Quat& q) {
  const double s = 1.5 - 0.5 * (q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  return {q.w * s, q.x * s, q.y * s, q.z * s};
}

math::Vec3 part(const ErrorVector& dx, int i) {
  return {dx[static_cast<std::size_t>(i)], dx[static_cast<std::size_t>(i + 1)], dx[static_cast<std::size_t>(i + 2)]};
}

}  // namespace

void InertialFilter::start(const InertialState& state, const InertialSpread& s) {
  x_ = state;
  x_.q_world_base = state.q_world_base.normalized();
  const double sigma[kErrInertial] = {s.p_m,
                                      s.p_m,
                                      s.p_m,
                                      s.v_mps,
                                      s.v_mps,
                                      s.v_mps,
                                      s.tilt_rad,
                                      s.tilt_rad,
                                      s.yaw_rad,
                                      s.gyro_bias_radps,
                                      s.gyro_bias_radps,
                                      s.gyro_bias_radps,
                                      s.accel_bias_mps2,
                                      s.accel_bias_mps2,
                                      s.accel_bias_mps2};
  ErrorVector variance{};
  for (std::size_t i = 0; i < kErrInertial; ++i) variance[i] = sigma[i] * sigma[i];
  p_.set_diagonal(variance);
  f_world_ = {0, 0, kGravity};
}

void InertialFilter::predict(const math::Vec3& gyro_radps, const math::Vec3& accel_mps2, double dt_s,
                             const InertialNoise& n) {
  const math::Vec3 w = gyro_radps - x_.gyro_bias_radps, a = accel_mps2 - x_.accel_bias_mps2;
  const math::Mat3 r = x_.q_world_base.matrix();
  f_world_ = r * (a + cross(w, a) * (0.5 * dt_s));  // the attitude of the middle of the step
  p_.propagate(r, f_world_, dt_s,
               {n.accel * n.accel * dt_s, n.gyro * n.gyro * dt_s, n.gyro_walk * n.gyro_walk * dt_s,
                n.accel_walk * n.accel_walk * dt_s, n.earth_field_walk * n.earth_field_walk * dt_s,
                n.body_field_walk * n.body_field_walk * dt_s, n.wind_walk * n.wind_walk * dt_s});

  const math::Vec3 dv{f_world_.x * dt_s, f_world_.y * dt_s, (f_world_.z - kGravity) * dt_s};
  x_.p_world_m += (x_.v_world_mps + 0.5 * dv) * dt_s;
  x_.v_world_mps += dv;
  x_.q_world_base = nearly_normalized(x_.q_world_base * math::Quat::exp(w * dt_s));
}

std::uint32_t InertialFilter::update(std::span<const Measurement> measurements, double gate) {
  ErrorVector dx{}, gain;
  const std::size_t states = p_.has_surroundings() ? kErrStates : kErrInertial;
  std::uint32_t used = 0;
  for (const Measurement& m : measurements) {
    const double s = p_.innovation(m, gain);
    double r = m.residual;
    for (std::uint32_t t = 0; t < m.terms; ++t) r -= m.coefficient[t] * dx[m.index[t]];
    if (!(s > 0) || !(r * r <= gate * s)) continue;  // also refuses what is not a number
    p_.correct(gain, s);
    const double k = r / s;
    for (std::size_t i = 0; i < states; ++i) dx[i] += gain[i] * k;
    ++used;
  }
  if (used) inject(dx);
  return used;
}

void InertialFilter::inject(const ErrorVector& dx) {
  x_.p_world_m += part(dx, kErrP);
  x_.v_world_mps += part(dx, kErrV);
  x_.q_world_base = nearly_normalized(math::Quat::exp(part(dx, kErrTheta)) * x_.q_world_base);
  x_.gyro_bias_radps += part(dx, kErrGyroBias);
  x_.accel_bias_mps2 += part(dx, kErrAccelBias);
  if (!p_.has_surroundings()) return;
  x_.earth_field_t += part(dx, kErrEarthField);
  x_.body_field_t += part(dx, kErrBodyField);
  x_.wind_world_mps.x += dx[kErrWind];
  x_.wind_world_mps.y += dx[kErrWind + 1];
}

void InertialFilter::open_surroundings(const InertialState& values, double earth_field_t, double body_field_t,
                                       double wind_mps) {
  x_.earth_field_t = values.earth_field_t;
  x_.body_field_t = values.body_field_t;
  x_.wind_world_mps = values.wind_world_mps;
  p_.open_surroundings(earth_field_t * earth_field_t, body_field_t * body_field_t, wind_mps * wind_mps);
}

void InertialFilter::reset_earth_field(const math::Vec3& field_t, double sigma_t) {
  x_.earth_field_t = field_t;
  for (int i = 0; i < 3; ++i) p_.reopen(kErrEarthField + i, sigma_t * sigma_t);
}

void InertialFilter::reset_body_field(const math::Vec3& field_t, double sigma_t) {
  x_.body_field_t = field_t;
  for (int i = 0; i < 3; ++i) p_.reopen(kErrBodyField + i, sigma_t * sigma_t);
}

void InertialFilter::turn_world(double angle_rad) {
  const math::Quat turn = math::Quat::from_axis_angle({0, 0, 1}, angle_rad);
  x_.p_world_m = turn.rotate(x_.p_world_m);
  x_.v_world_mps = turn.rotate(x_.v_world_mps);
  x_.q_world_base = (turn * x_.q_world_base).normalized();
  f_world_ = turn.rotate(f_world_);
  x_.earth_field_t = turn.rotate(x_.earth_field_t);
  x_.wind_world_mps = turn.rotate(x_.wind_world_mps);
  const math::SinCos a = math::sincos(angle_rad);
  for (const int i : {kErrP, kErrV, kErrTheta, kErrEarthField, kErrWind}) p_.turn_pair(i, a.cos, a.sin);
}

void InertialFilter::reset_yaw(double angle_rad, double variance) {
  const math::Quat turn = math::Quat::from_axis_angle({0, 0, 1}, angle_rad);
  x_.q_world_base = (turn * x_.q_world_base).normalized();
  f_world_ = turn.rotate(f_world_);
  const math::SinCos a = math::sincos(angle_rad);
  p_.turn_pair(kErrTheta, a.cos, a.sin);
  p_.reopen(kErrTheta + 2, variance);
}

void InertialFilter::reset_velocity(int axis, double v_mps, double variance) {
  x_.v_world_mps[axis] = v_mps;
  p_.reopen(kErrV + axis, variance);
}

void InertialFilter::reset_position(int axis, double p_m, double variance) {
  x_.p_world_m[axis] = p_m;
  p_.reopen(kErrP + axis, variance);
}

}  // namespace sinew::control
