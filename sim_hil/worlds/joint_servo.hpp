#pragma once
#include "math/random.hpp"
#include "sim_hil/worlds/joints.hpp"

namespace sinew::plant {

/// Motor, gear and drive of one joint. Numbers as of a small geared servo (stall 1.5 N m, 5.5 rad/s).
struct ServoParams {
  JointLimits limits{-1.4, 1.4, 5.5, 1.5};
  double position_gain = 25;       // 1/s: rad of error to rad/s; the lag behind a moving setpoint is its inverse
  double velocity_gain_nms = 0.3;  // N m per rad/s of error
  double armature_kgm2 = 1.5e-3;   // the rotor's inertia, seen through the gear
  double viscous_nms = 0.01, coulomb_nm = 0.03, coulomb_radps = 0.004;  // of the gear; full Coulomb friction well above
  double stop_nm_per_rad = 60, stop_nms = 0.2;                          // hard stops
  double ambient_c = 25, heat_c_per_nm2 = 30, heat_time_s = 60;         // copper losses go with the torque squared
};

/// Torques of a joint, and how warm its motor gets.
/// Thread:  owner.
class JointServo {
 public:
  explicit JointServo(const ServoParams& params) : p_(params) {}
  const ServoParams& params() const { return p_; }
  /// Torque of the motor, limited.
  double motor_nm(const JointDrive& drive, double q_rad, double v_radps) const;
  /// Torque of gear and stops, against the motion.
  double friction_nm(double q_rad, double v_radps) const;
  void warm(double effort_nm, double dt_s);
  double temperature_c() const { return p_.ambient_c + warmer_c_; }

 private:
  ServoParams p_;
  double warmer_c_ = 0;
};

/// What its encoder and drive report: 14 bits a turn, a rate with some noise, a current measured coarsely.
struct JointErrors {
  double step_rad = 6.283185307179586 / 16384, rate_noise_radps = 0.01, effort_noise_nm = 0.01;
};
double encoder_rad(double q_rad, const JointErrors& errors);

}  // namespace sinew::plant
