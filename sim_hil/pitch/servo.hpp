#pragma once
#include "sim_hil/worlds/joints.hpp"

namespace sinew::plant {

/// A DC motor at a bridge, a gear with play, an encoder and a drive that is a proportional controller: what small
/// humanoids have in each joint.
struct GearedServoParams {
  double stall_nm = 4.1, no_load_radps = 4.8;  // at full voltage; between them the torque falls linearly
  double armature_kgm2 = 0.0045;               // of the rotor, seen at the joint
  double gain_per_rad = 4.6;                   // share of the voltage for a radian of error; XM430: P gain 800
  double play_rad = 0;                         // of the gear, to each side of its middle
  double friction_nm = 0;                      // Coulomb, of motor and gear
  double encoder_step_rad = 0;                 // 0: exact
  bool encoder_at_motor = false;
  double ambient_c = 25, heat_c_per_nm2 = 6, heat_time_s = 120;  // copper losses go with the torque squared
};

/// What a servo does to its joint in one step: a torque, and a damping that acts on the joint's speed. The latter is
/// separate because an integrator that treats damping implicitly stays stable however strong it is.
struct ServoTorque {
  double effort_nm = 0, damping_nms = 0;
};

/// Source:  back-EMF and stall torque: the makers' torque-speed lines. Play: the rotor moves freely between the flanks
///          of its gear; on a flank it moves with the joint, and it leaves the flank when it would have to pull.
/// Thread:  owner.   RT: yes.
class GearedServo {
 public:
  explicit GearedServo(const GearedServoParams& params) : p_(params), play_rad_(-params.play_rad) {}

  const GearedServoParams& params() const { return p_; }
  void set_gain(double gain_per_rad) { p_.gain_per_rad = gain_per_rad; }
  /// `voltage`: the largest share of the voltage that the drive may use; the joint's angle, speed and acceleration.
  ServoTorque step(const JointDrive& drive, double voltage, double q_rad, double v_radps, double a_radps2, double dt_s);
  /// What the encoder says where the joint is at q.
  double encoder_rad(double q_rad) const;
  /// Of the motor in the last step, at the joint; a drive gets it from the current.
  double motor_nm() const { return motor_nm_; }
  double temperature_c() const { return p_.ambient_c + warmer_c_; }
  /// Where the rotor is between the flanks, -play to +play.
  double play_rad() const { return play_rad_; }

 private:
  double share_of_voltage(const JointDrive& drive, double most, double q_rad, double v_radps) const;

  GearedServoParams p_;
  double play_rad_ = 0, rotor_radps_ = 0;
  double motor_nm_ = 0, warmer_c_ = 0;
  bool free_ = false;  // the rotor touches no flank
};

}  // namespace sinew::plant
