#pragma once
// How vehicles move: velocities follow their commands with lag and limits, and solids stand in the way. Fixed steps,
// +, -, *, / and math/ only: the same bytes on every machine.
#include "sim_hil/places/surroundings.hpp"
#include "sim_hil/places/vehicle_kind.hpp"

namespace sinew::plant {

/// Frames:  world z up; yaw counter-clockwise from x; roll and pitch as in REP-103 (pitch positive: nose down).
struct BodyState {
  math::Vec3 p_world_m, v_world_mps;
  math::YawPitchRoll angles_rad;
  math::YawPitchRoll rates_radps;  // of the angles
  math::Vec3 accel_world_mps2;     // of base, without gravity
  bool touches = false;            // anything but what it stands on
  bool stands = false;             // on the ground

  math::Quat q_world_base() const { return math::Quat::from_yaw_pitch_roll(angles_rad); }
  /// Angular velocity, base.
  math::Vec3 gyro_radps() const;
};

/// What is commanded to rotors: velocities in the axes of the heading (x forward, y left, z up), and of the yaw.
struct RotorCommand {
  math::Vec3 v_mps;
  double turn_radps = 0;
};

/// Hovers where it is told nothing. Thread:  owner.   RT: yes.
class RotorMotion {
 public:
  explicit RotorMotion(const VehicleKind& kind) : kind_(&kind) {}
  /// `powered` false: the battery is empty, it sinks.
  /// The air, moving with `wind_mps` (world), drags it along; it leans against that.
  void step(BodyState& body, const RotorCommand& command, bool powered, const math::Vec3& wind_mps,
            const Surroundings& around, double dt_s);

 private:
  void lean(BodyState& body, const math::Vec3& accel_heading, const math::Vec3& wind_mps, double dt_s);
  const VehicleKind* kind_;
};

/// What is commanded to steered wheels: the spin of all of them, and the angles of the wheels of both axles, to the
/// left.
struct SteerCommand {
  double spin_radps = 0, front_rad = 0, rear_rad = 0;
};

/// Rolls on four wheels, skid-steered or with axles that steer, over ground of any shape. An edge higher than its
/// wheels climb, or a wall, stops it while its wheels go on turning. Thread:  owner.   RT: yes.
class WheelMotion {
 public:
  explicit WheelMotion(const VehicleKind& kind) : kind_(&kind) {}
  /// Spins of the left and the right wheels, positive forward.
  void step(BodyState& body, double left_radps, double right_radps, const Surroundings& around, double dt_s);
  /// Of a kind that steers. Both wheels of an axle roll on circles about one point (Ackermann); the wheels of the axle
  /// that does not steer do not slip sideways. left_rad() and right_rad() are the turns of its wheels.
  void step(BodyState& body, const SteerCommand& command, const Surroundings& around, double dt_s);

  double left_radps() const { return left_radps_; }
  double right_radps() const { return right_radps_; }
  double left_rad() const { return left_rad_; }  // turned since the start
  double right_rad() const { return right_rad_; }
  double front_steer_rad() const { return front_rad_; }  // as it is, to the left
  double rear_steer_rad() const { return rear_rad_; }

 private:
  struct Feet {
    double front_left, front_right, rear_left, rear_right;  // heights of the ground under the wheels
    double mean() const { return (front_left + front_right + rear_left + rear_right) / 4; }
    double highest() const;
  };
  Feet feet(const math::Vec3& p, double yaw, const Surroundings& around) const;
  /// It may be there, when it rolls forward or back.
  bool fits(const math::Vec3& p, const Feet& feet, bool forward, const Surroundings& around) const;

  /// Velocities in its own axes: forward, to the left; and its turning to the left.
  struct Rolling {
    double along_mps = 0, side_mps = 0, turn_radps = 0;
  };
  void roll(BodyState& body, const Rolling& rolling, const Surroundings& around, double dt_s);

  const VehicleKind* kind_;
  double spin_radps_ = 0, front_rad_ = 0, rear_rad_ = 0;
  double left_radps_ = 0, right_radps_ = 0, left_rad_ = 0, right_rad_ = 0;
  double fall_mps_ = 0;
};

}  // namespace sinew::plant
