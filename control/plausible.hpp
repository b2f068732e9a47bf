#pragma once
// Limits of any vehicle of ours: an input beyond them comes from something broken. Modules answer with a fault and
// publish nothing, so that the lease of the last command runs out.
#include "math/linear.hpp"
#include "msg/flight.hpp"
#include "msg/ground_motion.hpp"

namespace sinew::control {

inline constexpr double kMostTurn_radps = 60;  // gyros end at 35 (2000 deg/s); filtered and bias-corrected, some more
inline constexpr double kMostSpeed_mps = 150, kMostAway_m = 1e6;
inline constexpr double kMostForce_mps2 = 200;    // 20 g: more than an accelerometer measures
inline constexpr double kMostMotion_radps = 100;  // of the ground: several pixels a frame of any camera

/// Also false for values that are not finite.
inline bool within(const msg::Vec3& v, double most) {
  const auto inside = [most](double x) { return x >= -most && x <= most; };
  return inside(v.x) && inside(v.y) && inside(v.z);
}

inline bool is_rotation(const msg::Quat& q) {
  const double n = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
  return n > 0.998 && n < 1.002;
}

inline bool plausible(const msg::NavState& n) {
  return is_rotation(n.q_world_base) && within(n.gyro_radps, kMostTurn_radps) &&
         within(n.v_world_mps, kMostSpeed_mps) && within(n.p_world_m, kMostAway_m) &&
         within(n.pad_world_m, kMostAway_m) && within({n.height_m, 0, 0}, kMostAway_m);
}

inline bool plausible(const msg::FlightSetpoint& s) {
  return within(s.p_world_m, kMostAway_m) && within(s.v_world_mps, kMostSpeed_mps) && within({s.yaw_rad, 0, 0}, 1e3);
}

inline bool plausible(const msg::AttitudeSetpoint& s) {
  return is_rotation(s.q_world_base) && s.thrust_n >= 0 && s.thrust_n < 1e5;
}

inline bool plausible(const msg::GroundMotion& m) {
  return within({m.forward_radps, m.left_radps, 0}, kMostMotion_radps);
}

}  // namespace sinew::control
