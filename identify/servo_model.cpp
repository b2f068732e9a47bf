#include "identify/servo_model.hpp"

#include <algorithm>

namespace sinew::identify {
namespace {

constexpr double kBearingShare = 0.1;  // of the Coulomb friction: the joint's own, while the gear transmits nothing

/// exp(-x) for x >= 0, to 1e-5 of it below 0.5; falls to 0 for large x.
double decay(double x) { return 1 / (1 + x * (1 + x * (1.0 / 2 + x * (1.0 / 6 + x * (1.0 / 24))))); }

/// A mass with a constant torque and a damping over a step.
struct Moved {
  double v = 0, way = 0;
};
Moved moved(double v, double torque_nm, double damping_nms, double inertia_kgm2, double step_s) {
  const double x = step_s * damping_nms / inertia_kgm2;
  if (x < 1e-6) {
    const double dv = step_s * torque_nm / inertia_kgm2;
    return {v + dv, step_s * (v + 0.5 * dv)};
  }
  const double end = torque_nm / damping_nms, share = 1 - decay(x);
  const double v_new = v + (end - v) * share;
  return {v_new, step_s * (end + (v - end) * share / x)};
}

class Joint {
 public:
  Joint(const ServoModel& m, const ServoModel::Run& how)
      : m_(m),
        brake_nms_(m.stall_nm / m.no_load_radps),
        link_kgm2_(std::max(m.inertia_kgm2 - m.rotor_kgm2, 1e-3 * m.inertia_kgm2)),
        q_(how.first_rad) {
    turn_ = math::sincos(q_);
    // The link hangs on the flank that gravity presses it to.
    play_ = gravity_nm() > 0 ? -m.play_rad : m.play_rad;
    if (m.encoder_at_motor) q_ -= play_;
  }

  double encoder_rad() const { return m_.encoder_at_motor ? q_ + play_ : q_; }
  /// Of the motor now.
  double motor_nm(double target_rad) const {
    if (math::is_nan(target_rad)) return 0;
    const double nm = m_.stall_nm * std::clamp(m_.gain_per_rad * (target_rad - encoder_rad()), -1.0, 1.0) -
                      brake_nms_ * (free_ ? w_ : v_);
    return std::clamp(nm, -m_.limit_nm, m_.limit_nm);
  }

  /// NaN: no torque.
  void step(double target_rad, double step_s) {
    step_s_ = step_s;
    if (++count_ % 16 == 0) turn_ = math::sincos(q_);
    const double rotor = free_ ? w_ : v_;
    double brake = 0, drive = 0;
    if (!math::is_nan(target_rad)) {
      const double ahead = encoder_rad() + 0.5 * step_s_ * (m_.encoder_at_motor ? rotor : v_);
      brake = brake_nms_;
      drive = m_.stall_nm * std::clamp(m_.gain_per_rad * (target_rad - ahead), -1.0, 1.0);
      const double motor = drive - brake * rotor;
      if (math::fabs(motor) > m_.limit_nm) drive = motor > 0 ? m_.limit_nm : -m_.limit_nm, brake = 0;
    }
    if (free_)
      step_free(drive, brake);
    else
      step_together(drive, brake);
  }

 private:
  /// In the middle of the step.
  double gravity_nm() const {
    const double half = 0.5 * step_s_ * v_;
    return m_.gravity_cos_nm * (turn_.cos - half * turn_.sin) + m_.gravity_sin_nm * (turn_.sin + half * turn_.cos);
  }
  double coulomb_nms(double v) const { return m_.coulomb_nm / (math::fabs(v) + m_.slow_radps); }

  void move_joint(double way) {
    q_ += way;
    const double c = turn_.cos, s = turn_.sin, half = 0.5 * way * way;
    turn_.cos = c - s * way - c * half, turn_.sin = s + c * way - s * half;
  }

  void step_together(double drive, double brake) {
    const double middle = v_ + 0.5 * step_s_ * a_, rubbing = coulomb_nms(middle);
    const Moved m = moved(v_, drive + gravity_nm(), brake + rubbing + m_.viscous_nms, m_.inertia_kgm2, step_s_);
    const double a = (m.v - v_) / step_s_;
    if (m_.play_rad > 0) {
      // What the flank gives to the link; it can push and not pull.
      const double flank_nm = drive - (brake + rubbing) * 0.5 * (v_ + m.v) - m_.rotor_kgm2 * a;
      if (flank_nm * play_ < 0) {
        free_ = true;
        w_ = v_;
        step_free(drive, brake);
        return;
      }
    }
    a_ = a;
    v_ = m.v;
    move_joint(m.way);
  }

  void step_free(double drive, double brake) {
    const Moved rotor = moved(w_, drive, brake + (1 - kBearingShare) * coulomb_nms(w_), m_.rotor_kgm2, step_s_);
    const Moved link = moved(v_, gravity_nm(), m_.viscous_nms + kBearingShare * coulomb_nms(v_), link_kgm2_, step_s_);
    a_ = (link.v - v_) / step_s_;
    w_ = rotor.v, v_ = link.v;
    play_ += rotor.way - link.way;
    move_joint(link.way);
    if (math::fabs(play_) < m_.play_rad) return;
    const double beyond = play_ - math::copysign(m_.play_rad, play_), share = m_.rotor_kgm2 / m_.inertia_kgm2;
    move_joint(beyond * share);
    play_ -= beyond;
    v_ += share * (w_ - v_);
    a_ = 0;
    free_ = false;
  }

  const ServoModel& m_;
  double step_s_ = 0, brake_nms_, link_kgm2_;
  double q_, v_ = 0, a_ = 0;
  double play_ = 0, w_ = 0;  // the rotor against the link, and its speed while it is free
  bool free_ = false;
  math::SinCos turn_{};
  unsigned count_ = 0;
};

}  // namespace

void ServoModel::run(const CommandLine& commands, const Run& how, std::span<const double> time_s,
                     std::span<double> position_rad, std::span<double> effort_nm) const {
  if (time_s.empty()) return;
  const std::size_t count = commands.time_s.size();
  double t = count == 0 ? time_s[0] : std::min(time_s[0], commands.time_s[0]), target_rad = math::kNan;
  Joint joint(*this, how);
  // From one event to the next, a command that arrives or a measurement, in equal steps.
  for (std::size_t command = 0, sample = 0; sample < time_s.size();) {
    const double arrives = command < count ? commands.time_s[command] + delay_s : math::kInf;
    const double until = std::min(arrives, time_s[sample]), way = until - t;
    if (way > 0) {
      const double steps = math::ceil(way / how.step_s);
      for (double k = 0; k < steps; ++k) joint.step(target_rad, way / steps);
      t = until;
    }
    if (arrives <= time_s[sample]) {
      target_rad = commands.target_rad[command++];
    } else {
      position_rad[sample] = joint.encoder_rad();
      effort_nm[sample++] = joint.motor_nm(target_rad) + effort_offset_nm;
    }
  }
}

const std::array<ServoParameterText, kServoParameters>& servo_parameters() {
  using M = ServoModel;
  static constexpr std::array<ServoParameterText, kServoParameters> kAll{{
      {"delay", "s", "from a command to the motor", &M::delay_s},
      {"gain", "1/rad", "share of the voltage for a radian of error", &M::gain_per_rad},
      {"stall", "N m", "torque at full voltage and no speed", &M::stall_nm},
      {"no_load", "rad/s", "speed at full voltage and no torque", &M::no_load_radps},
      {"limit", "N m", "of the motor's torque, by its current", &M::limit_nm},
      {"inertia", "kg m^2", "of link and rotor about the joint", &M::inertia_kgm2},
      {"rotor", "kg m^2", "of the rotor, seen at the joint", &M::rotor_kgm2},
      {"coulomb", "N m", "friction of motor and gear", &M::coulomb_nm},
      {"slow", "rad/s", "speed at which half of the Coulomb friction is there", &M::slow_radps},
      {"viscous", "N m s/rad", "damping of the joint, without the motor's", &M::viscous_nms},
      {"gravity_cos", "N m", "gravity's torque at 0 rad", &M::gravity_cos_nm},
      {"gravity_sin", "N m", "gravity's torque at a quarter turn", &M::gravity_sin_nm},
      {"play", "rad", "of the gear, to each side of its middle", &M::play_rad},
      {"effort_offset", "N m", "what the effort reads at no torque", &M::effort_offset_nm},
  }};
  return kAll;
}

}  // namespace sinew::identify
