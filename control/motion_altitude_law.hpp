#pragma once
#include "math/linear.hpp"
#include "msg/flight.hpp"
#include "msg/ground_motion.hpp"
#include "msg/safety.hpp"

namespace sinew::control {

/// Numbers of the flight; the module MotionAltitude gives each its range.
struct MotionAltitudeParams {
  double mass_kg = 1.2;
  double wanted_motion_radps = 0.75, speed_mps = 1.5;  // together: a height of 2 m
  // The vehicle's drag along base x and y, by which the accelerometer is an airspeed sensor.
  double drag_n_per_mps = 0.28, drag_n_per_m2ps2 = 0.06;
  double settle_s = 2, spin_up_s = 0.7;  // at rest, level: the accelerometer's zero is learned
  double climb_mps = 0.7, accel_mps2 = 0.5;
  double follow_share = 0.8;  // of the speed: from there on the motion holds the height
  double observer_radps = 5;  // how fast the estimate of height and climb follows the motion
  double kp_height = 4, kd_height = 3.6, ki_height = 0.8, integral_mps2 = 3;
  double kp_speed = 0.06, ki_speed = 0.03, kp_drift = 0.08, ki_drift = 0.02;  // rad for each m/s, and its sum
  double airspeed_time_s = 0.4, drift_time_s = 0.3;                           // of the low passes
  double tilt_rad = 0.25;
  double least_height_share = 0.2, most_height_share = 2;  // what motion says beyond is not believed
  double most_step_share = 0.3;                            // of it: what a new height may differ by, for the observer
  double most_sink_mps = 0.6, most_climb_mps = 1.0;        // over the ground
  double thrust_min_n = 3, thrust_max_n = 20;
  double motion_lost_s = 0.5;                        // without motion for so long: it neither climbs nor sinks
  double sink_thrust_share = 0.97, sink_s = 10;      // of a landing
  double feet_below_base_m = 0.12, camera_m = 0.04;  // below the base
};

/// Flies forward over ground that it does not know, at a height that the ground's motion below gives: speed over ground
/// divided by height is held at a wanted value by climbing and sinking, without range finder, barometer or position.
///
/// Takes off and climbs by the accelerometer alone, a few seconds, then holds
/// - the height: an observer of height and climb over the ground, driven by the accelerometer and corrected by
///   speed_mps / motion, and a PID law on thrust;
/// - the speed: through the air, by pitch. Rotors and body drag along base x and nothing else pushes along it, so the
///   accelerometer's x is the drag, whose curve the vehicle knows. The sensor's zero is learned while the vehicle
///   stands level. Wind is not seen: a head wind slows the vehicle over the ground, and it sinks, as insects do;
/// - no drift to the side: by roll, on the motion to the side; the heading as at the start.
/// The height is right for the wanted speed over ground: a height of speed_mps / wanted_motion_radps where there is no
/// wind.
/// Frames:  base x forward, y left, z up.
/// Source:  F. Ruffier, N. Franceschini, "Optic flow regulation: the key to aircraft automatic guidance", Robotics and
///          Autonomous Systems 50 (2005) 177 (ventral motion held by lift, pitch sets the speed, head wind makes it
///          sink); R. Leishman, J. Macdonald, R. Beard, T. McLain, "Quadrotors and accelerometers", IEEE Control
///          Systems 34 (2014) 28 (drag as airspeed).
/// Thread:  owner.   RT: yes.
class MotionAltitudeLaw {
 public:
  MotionAltitudeParams params;

  struct Input {
    msg::NavState nav;                          // attitude and its validity; nothing else is used
    math::Vec3 force_mps2;                      // specific force, base, mean since the last step
    const msg::GroundMotion* motion = nullptr;  // a new one; null: none
    bool by_range = false;                      // the range finder's height in place of the motion's
    double range_m = 0;                         // a new one; 0: none
    bool permitted = true;                      // to arm
    msg::FailsafeAction action = msg::FailsafeAction::none;
  };

  void reset();
  void step(const Input& in, msg::Time now, double dt_s);
  const msg::AttitudeSetpoint& setpoint() const { return setpoint_; }
  const msg::AltitudeState& state() const { return state_; }
  /// The airspeed at which the vehicle's drag is this specific force (force opposes speed).
  static double airspeed_of(double force_mps2, const MotionAltitudeParams& params);

 private:
  double nominal_m() const { return params.speed_mps / params.wanted_motion_radps; }
  void enter(msg::AltitudePhase phase) {
    state_.phase = phase;
    in_phase_s_ = 0;
  }
  void learn_zero(const Input& in, double dt_s);
  void run_phase(const Input& in, double dt_s);
  void observe(const Input& in, double dt_s);
  void take_height(double height_m, double since_s);
  void take_motion(const msg::GroundMotion& motion);
  double vertical(double dt_s);
  void fly(const Input& in, double dt_s);
  void stand(const Input& in, double thrust_n, bool armed);

  msg::AttitudeSetpoint setpoint_;
  msg::AltitudeState state_;
  math::Vec3 zero_mps2_, zero_sum_;
  double zero_s_ = 0, in_phase_s_ = 0;
  double lift_integral_mps2_ = 0, pitch_integral_rad_ = 0, roll_integral_rad_ = 0;
  double drag_x_mps2_ = 0, drag_y_mps2_ = 0;  // low-passed
  double drift_mps_ = 0;                      // to the left, by the motion
  double wanted_mps_ = 0, wanted_m_ = 0;      // moved towards what is wanted
  double motion_age_s_ = 0, height_age_s_ = 0, yaw_rad_ = 0;
};

}  // namespace sinew::control
