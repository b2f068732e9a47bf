#include "sim_hil/pitch/servo.hpp"

#include <algorithm>

#include "math/elementary.hpp"

namespace sinew::plant {
namespace {

constexpr double kSlow_radps = 0.1;    // Coulomb friction is full well above
constexpr double kBearingShare = 0.1;  // of the friction: what is left where the gear transmits nothing
constexpr double kVelocityGain = 2;    // of the drive's own speed controller: share of the voltage per no-load speed

/// NaN becomes 0: a drive with a nonsense command does nothing.
double within_most(double x, double most) { return x == x ? std::clamp(x, -most, most) : 0; }

/// Coulomb friction as a damping: c / (|v| + slow) times v.
double coulomb_nms(double friction_nm, double v_radps) { return friction_nm / (math::fabs(v_radps) + kSlow_radps); }

}  // namespace

double GearedServo::encoder_rad(double q_rad) const {
  const double at_rad = p_.encoder_at_motor ? q_rad + play_rad_ : q_rad;
  return p_.encoder_step_rad > 0 ? p_.encoder_step_rad * math::round(at_rad / p_.encoder_step_rad) : at_rad;
}

double GearedServo::share_of_voltage(const JointDrive& d, double most, double q_rad, double v_radps) const {
  const auto of_torque = [&](double nm) { return nm / p_.stall_nm + v_radps / p_.no_load_radps; };
  switch (d.mode) {
    case DriveMode::off:
      return 0;
    case DriveMode::position:
      return within_most(p_.gain_per_rad * (d.position_rad - encoder_rad(q_rad)), most);
    case DriveMode::velocity:
      return within_most((d.velocity_radps + kVelocityGain * (d.velocity_radps - v_radps)) / p_.no_load_radps, most);
    case DriveMode::effort:
      return within_most(of_torque(d.effort_nm), most);
    case DriveMode::impedance:
      return within_most(of_torque(d.kp_nm_per_rad * (d.position_rad - encoder_rad(q_rad)) +
                                   d.kd_nms_per_rad * (d.velocity_radps - v_radps) + d.effort_nm),
                         most);
  }
  return 0;
}

ServoTorque GearedServo::step(const JointDrive& drive, double voltage, double q_rad, double v_radps, double a_radps2,
                              double dt_s) {
  const bool on = drive.mode != DriveMode::off;
  const double drive_nm =
      on ? p_.stall_nm * share_of_voltage(drive, voltage, q_rad, free_ ? rotor_radps_ : v_radps) : 0;
  const double brake_nms = on ? p_.stall_nm / p_.no_load_radps : 0;  // back-EMF, while the bridge drives

  if (!free_ && p_.play_rad > 0) {
    // The flank can push and not pull: what it gives to the joint is what the motor has left after its own rotor.
    const double to_joint_nm =
        drive_nm - (brake_nms + coulomb_nms(p_.friction_nm, v_radps)) * v_radps - p_.armature_kgm2 * a_radps2;
    if ((play_rad_ > 0 && to_joint_nm < 0) || (play_rad_ < 0 && to_joint_nm > 0)) {
      free_ = true;
      rotor_radps_ = v_radps;
    }
  }
  ServoTorque out;
  if (free_) {
    const double drag_nms = brake_nms + coulomb_nms(p_.friction_nm, rotor_radps_);
    rotor_radps_ = (rotor_radps_ + dt_s * drive_nm / p_.armature_kgm2) / (1 + dt_s * drag_nms / p_.armature_kgm2);
    play_rad_ += (rotor_radps_ - v_radps) * dt_s;
    if (math::fabs(play_rad_) >= p_.play_rad) {
      play_rad_ = std::clamp(play_rad_, -p_.play_rad, p_.play_rad);
      free_ = false;
      // The rotor's momentum goes into the joint, which is modelled with the rotor's inertia on it.
      out.effort_nm = p_.armature_kgm2 * (rotor_radps_ - v_radps) / dt_s;
      rotor_radps_ = v_radps;
    }
    out.damping_nms = coulomb_nms(kBearingShare * p_.friction_nm, v_radps);
    motor_nm_ = drive_nm - brake_nms * rotor_radps_;
  } else {
    out = {drive_nm, brake_nms + coulomb_nms(p_.friction_nm, v_radps)};
    motor_nm_ = drive_nm - brake_nms * v_radps;
  }
  warmer_c_ += dt_s / p_.heat_time_s * (p_.heat_c_per_nm2 * motor_nm_ * motor_nm_ - warmer_c_);
  return out;
}

}  // namespace sinew::plant
