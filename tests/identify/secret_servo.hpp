#pragma once
// A joint whose numbers nobody told the fit, and what a robot would record of it. It is not the fit's model: rotor and
// link are two masses all the time, the gear's flanks are stiff springs with dampers, the drive sees the encoder's
// steps, and it runs in steps of 10 us.
#include <algorithm>
#include <deque>

#include "control/excitation_plan.hpp"
#include "identify/servo_fit.hpp"
#include "math/random.hpp"

namespace sinew::identify::test {

struct SecretServo {
  double stall_nm = 4, no_load_radps = 5, gain_per_rad = 4.6, delay_s = 0.025;
  double rotor_kgm2 = 0.004, link_kgm2 = 0.01;
  double coulomb_nm = 0.1, slow_radps = 0.05, bearing_share = 0.1;  // the share is of the link's own bearing
  double viscous_nms = 0.01;                                        // of the link
  double gravity_nm = 0.4, gravity_at_rad = 0;  // largest torque, and the angle at which the link hangs
  double play_rad = 0.004;
  double encoder_step_rad = 2 * math::kPi / 4096;
  bool encoder_at_motor = false;
  double effort_noise_nm = 0.02, effort_step_nm = 0.005;
  bool measures_effort = true;

  /// What the fit should find.
  double truth(ServoParameter p) const {
    switch (p) {
      case ServoParameter::delay:
        return delay_s;
      case ServoParameter::gain:
        return gain_per_rad;
      case ServoParameter::stall:
        return stall_nm;
      case ServoParameter::no_load:
        return no_load_radps;
      case ServoParameter::limit:
        return math::kInf;
      case ServoParameter::inertia:
        return link_kgm2 + rotor_kgm2;
      case ServoParameter::rotor:
        return rotor_kgm2;
      case ServoParameter::coulomb:
        return coulomb_nm;
      case ServoParameter::slow:
        return slow_radps;
      case ServoParameter::viscous:
        return viscous_nms;
      case ServoParameter::gravity_cos:
        return gravity_nm * math::sin(gravity_at_rad);
      case ServoParameter::gravity_sin:
        return -gravity_nm * math::cos(gravity_at_rad);
      case ServoParameter::play:
        return play_rad;
      case ServoParameter::effort_offset:
        return 0;
    }
    return 0;
  }
};

/// Servos from a small one to a strong one, links from a finger to a leg.
inline SecretServo draw_servo(std::uint64_t seed) {
  math::Random random(seed, 0x73656372);
  const auto between = [&](double low, double high) {
    return low * math::exp(random.uniform() * math::log(high / low));
  };
  SecretServo s;
  s.stall_nm = between(1.2, 6);
  s.no_load_radps = between(3.5, 7);
  s.rotor_kgm2 = between(0.0006, 0.0016) * s.stall_nm;
  s.gain_per_rad = between(3.5, 9);
  s.play_rad = between(0.08, 0.5) * math::kPi / 180;
  s.coulomb_nm = between(0.01, 0.05) * s.stall_nm;
  s.slow_radps = between(0.02, 0.15);
  s.bearing_share = random.uniform(0.02, 0.2);
  s.encoder_at_motor = random.uniform() < 0.5;
  s.link_kgm2 = between(0.001, 0.01) * s.stall_nm;
  s.viscous_nms = between(0.005, 0.05) * s.stall_nm / s.no_load_radps;
  s.gravity_nm = between(0.03, 0.3) * s.stall_nm;
  s.gravity_at_rad = random.uniform(-1.2, 1.2);
  s.delay_s = random.uniform(0.008, 0.036);
  s.effort_noise_nm = 0.008 * s.stall_nm;
  s.effort_step_nm = 0.0015 * s.stall_nm;
  return s;
}

/// Commands and measurements at `rate_hz` while the plan runs; they are not in step with each other.
inline ServoRecord record_of(const SecretServo& s, const control::ExcitationPlan& plan,
                             const control::ExcitationRange& range, std::uint64_t seed, double rate_hz = 125) {
  constexpr double kStep_s = 1e-5;
  math::Random random(seed, 0x6e6f6973);
  ServoRecord r;
  double q = range.centre_rad, v = 0, rotor = q, w = 0, target = q;
  const double flank_nm = 6000 * s.stall_nm, flank_nms = 2 * math::sqrt(flank_nm * s.rotor_kgm2);  // per rad, per rad/s
  const double brake = s.stall_nm / s.no_load_radps;
  std::deque<std::pair<double, double>> sent;  // when it is obeyed, and the target
  std::size_t commands = 0;
  double next_sample_s = random.uniform() / rate_hz;
  const auto steps = static_cast<std::size_t>(plan.whole_s(1) / kStep_s);
  const auto encoder = [&] {
    return s.encoder_step_rad * math::round((s.encoder_at_motor ? rotor : q) / s.encoder_step_rad);
  };
  math::SinCos hangs{};
  for (std::size_t k = 0; k < steps; ++k) {
    const double t = static_cast<double>(k) * kStep_s;
    if (t * rate_hz >= static_cast<double>(commands)) {
      const double at = static_cast<double>(commands++) / rate_hz;
      const double setpoint = plan.target_rad(0, 1, range, at);
      r.commands.time_s.push_back(at), r.commands.target_rad.push_back(setpoint);
      sent.emplace_back(at + s.delay_s, setpoint);
    }
    for (; !sent.empty() && sent.front().first <= t; sent.pop_front()) target = sent.front().second;
    const double motor_nm = s.stall_nm * std::clamp(s.gain_per_rad * (target - encoder()), -1.0, 1.0) - brake * w;
    const double gap = rotor - q, beyond = gap - std::clamp(gap, -s.play_rad, s.play_rad);
    double through_nm = beyond == 0 ? 0 : flank_nm * beyond + flank_nms * (w - v);
    if (through_nm * beyond < 0) through_nm = 0;  // flanks push and do not pull
    const auto rubs = [&](double share, double speed) {
      return share * s.coulomb_nm * speed / (math::fabs(speed) + s.slow_radps);
    };
    if (k % 8 == 0) hangs = math::sincos(q - s.gravity_at_rad);
    w += kStep_s / s.rotor_kgm2 * (motor_nm - through_nm - rubs(1 - s.bearing_share, w));
    v += kStep_s / s.link_kgm2 * (through_nm - s.gravity_nm * hangs.sin - s.viscous_nms * v - rubs(s.bearing_share, v));
    rotor += kStep_s * w;
    q += kStep_s * v;
    if (t + kStep_s < next_sample_s) continue;
    next_sample_s += 1 / rate_hz;
    r.time_s.push_back(t + kStep_s);
    r.position_rad.push_back(encoder());
    if (!s.measures_effort) continue;
    const double measured_nm = motor_nm + s.effort_noise_nm * random.normal();
    r.effort_nm.push_back(s.effort_step_nm * math::round(measured_nm / s.effort_step_nm));
  }
  return r;
}

}  // namespace sinew::identify::test
