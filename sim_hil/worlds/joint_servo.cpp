#include "sim_hil/worlds/joint_servo.hpp"

#include "math/elementary.hpp"

namespace sinew::plant {
namespace {

/// NaN becomes 0: a drive with a nonsense command does nothing.
double within(double x, double most) { return x > most ? most : x < -most ? -most : x == x ? x : 0; }

}  // namespace

double JointServo::motor_nm(const JointDrive& drive, double q_rad, double v_radps) const {
  const JointLimits& most = p_.limits;
  const auto follow = [&](double speed) { return p_.velocity_gain_nms * (within(speed, most.speed_radps) - v_radps); };
  switch (drive.mode) {
    case DriveMode::off:
      return 0;
    case DriveMode::position:
      return within(follow(p_.position_gain * (drive.position_rad - q_rad)), most.effort_nm);
    case DriveMode::velocity:
      return within(follow(drive.velocity_radps), most.effort_nm);
    case DriveMode::effort:
      return within(drive.effort_nm, most.effort_nm);
    case DriveMode::impedance:
      return within(drive.kp_nm_per_rad * (drive.position_rad - q_rad) +
                        drive.kd_nms_per_rad * (drive.velocity_radps - v_radps) + drive.effort_nm,
                    most.effort_nm);
  }
  return 0;
}

double JointServo::friction_nm(double q_rad, double v_radps) const {
  double nm = -p_.viscous_nms * v_radps - p_.coulomb_nm * v_radps / (math::fabs(v_radps) + p_.coulomb_radps);
  const double beyond = q_rad > p_.limits.most_rad    ? q_rad - p_.limits.most_rad
                        : q_rad < p_.limits.least_rad ? q_rad - p_.limits.least_rad
                                                      : 0;
  if (beyond != 0) nm -= p_.stop_nm_per_rad * beyond + p_.stop_nms * v_radps;
  return nm;
}

void JointServo::warm(double effort_nm, double dt_s) {
  warmer_c_ += dt_s / p_.heat_time_s * (p_.heat_c_per_nm2 * effort_nm * effort_nm - warmer_c_);
}

double encoder_rad(double q_rad, const JointErrors& errors) {
  return errors.step_rad > 0 ? errors.step_rad * math::round(q_rad / errors.step_rad) : q_rad;
}

}  // namespace sinew::plant
