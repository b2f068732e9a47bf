#pragma once
#include "math/linear.hpp"
#include "msg/flight.hpp"

namespace sinew::control {

/// Numbers of the position loop; the module PositionController gives each its range.
struct PositionParams {
  double mass_kg = 1.2;
  double kp_xy = 1.2, kp_z = 1.5;                        // 1/s: position error to velocity
  double kv_xy = 3.0, kv_z = 4.5;                        // 1/s: velocity error to acceleration
  double ki_xy = 0.6, ki_z = 1.5;                        // 1/s^2: integral of the velocity error
  double integral_xy_mps2 = 2.0, integral_z_mps2 = 3.0;  // largest share of the integrals
  double speed_xy_mps = 1.5, climb_mps = 1.2, sink_mps = 0.8;
  double tilt_rad = 0.35;
  double thrust_min_n = 3.0, thrust_max_n = 20.0;
  double blind_thrust_share = 0.97;  // of the thrust so far, when even the height is unknown: sinks slowly
};

/// Position and velocity to attitude and thrust: proportional on position, proportional and integral on velocity.
/// Frames:  world z up; thrust along base z.
/// Without a position it keeps the tilt that it had learned against the wind, and controls the height only. Without a
/// height it lets the vehicle sink on a little less thrust than it had learned to need.
/// Limits:  speed, tilt and thrust; the integrals stop growing while the limit that they push against is reached.
/// Thread:  owner.   RT: yes.
class PositionLaw {
 public:
  PositionParams params;

  void reset() { integral_mps2_ = {}; }
  msg::AttitudeSetpoint step(const msg::NavState& nav, const msg::FlightSetpoint& wanted, double dt_s);

 private:
  math::Vec3 wished_acceleration(const math::Vec3& error_mps, const msg::NavState& nav) const;
  void integrate(const math::Vec3& error_mps, const math::Vec3& frozen, double dt_s);
  math::Vec3 velocity_setpoint(const msg::NavState& nav, const msg::FlightSetpoint& wanted) const;
  math::Vec3 integral_mps2_;
};

}  // namespace sinew::control
