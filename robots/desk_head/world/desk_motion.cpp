#include "robots/desk_head/world/desk_motion.hpp"

#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

using math::SinCos;
using math::Vec3;

Wave::Wave(double amplitude, const std::array<double, kSines>& hz, math::Random& random) {
  constexpr std::array<double, kSines> kShare{0.55, 0.3, 0.15};
  for (std::size_t i = 0; i < kSines; ++i) {
    amplitude_[i] = amplitude * kShare[i];
    rate_radps_[i] = 2 * math::kPi * hz[i] * random.uniform(0.75, 1.25);
    phase_[i] = 2 * math::kPi * random.uniform();
  }
}

Wave::Value Wave::at(double t_s) const {
  Value v;
  for (std::size_t i = 0; i < kSines; ++i) {
    const SinCos a = math::sincos(rate_radps_[i] * t_s + phase_[i]);
    v.x += amplitude_[i] * a.sin;
    v.dx += amplitude_[i] * rate_radps_[i] * a.cos;
    v.ddx -= amplitude_[i] * rate_radps_[i] * rate_radps_[i] * a.sin;
  }
  return v;
}

Rocking::Rocking(double tilt_rad, double yaw_rad, std::uint64_t seed) {
  math::Random random(seed, 0x726f636b);
  roll_ = Wave(tilt_rad, {0.12, 0.27, 0.5}, random);
  pitch_ = Wave(tilt_rad, {0.10, 0.31, 0.55}, random);
  yaw_ = Wave(yaw_rad, {0.08, 0.22, 0.45}, random);
}

Rocking::State Rocking::at(double t_s) const {
  const Wave::Value f = roll_.at(t_s), p = pitch_.at(t_s), y = yaw_.at(t_s);
  State s;
  s.q_world_base = math::Quat::from_yaw_pitch_roll({y.x, p.x, f.x});
  const SinCos cf = math::sincos(f.x), cp = math::sincos(p.x);
  // Rates of roll, pitch and yaw to the angular velocity in base, and its derivative.
  s.motion.w_radps = {f.dx - y.dx * cp.sin, p.dx * cf.cos + y.dx * cf.sin * cp.cos,
                      y.dx * cf.cos * cp.cos - p.dx * cf.sin};
  s.motion.dw_radps2 = {f.ddx - y.ddx * cp.sin - y.dx * p.dx * cp.cos,
                        p.ddx * cf.cos - p.dx * f.dx * cf.sin + y.ddx * cf.sin * cp.cos +
                            y.dx * (f.dx * cf.cos * cp.cos - p.dx * cf.sin * cp.sin),
                        y.ddx * cf.cos * cp.cos - y.dx * (f.dx * cf.sin * cp.cos + p.dx * cf.cos * cp.sin) -
                            p.ddx * cf.sin - p.dx * f.dx * cf.cos};
  s.motion.a_mps2 = s.q_world_base.conjugate().rotate({0, 0, kGravity});
  return s;
}

BallPath::BallPath(double speed, std::uint64_t seed) : speed_(speed) {
  math::Random random(seed, 0x62616c6c);
  x_ = Wave(0.40, {0.09, 0.2, 0.4}, random);
  y_ = Wave(0.95, {0.13, 0.29, 0.5}, random);
  z_ = Wave(0.40, {0.11, 0.25, 0.45}, random);
  pace_ = Wave(0.9, {0.05, 0.11, 0.2}, random);
}

Vec3 BallPath::at(double t_s) const {
  const double along = speed_ * (t_s + pace_.at(t_s).x);  // sometimes faster, sometimes slower
  return {1.70 + x_.at(along).x, y_.at(along).x, 1.15 + z_.at(along).x};
}

}  // namespace sinew::plant
