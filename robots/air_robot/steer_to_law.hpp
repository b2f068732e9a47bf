#pragma once
#include "math/linear.hpp"
#include "msg/flight.hpp"
#include "msg/head.hpp"
#include "msg/motion.hpp"
#include "msg/safety.hpp"

namespace sinew::air_robot {

/// Numbers of the flight to a target; the module SteerTo gives each its range.
struct SteerToParams {
  double height_m = 1.6;                                      // of the flight, over the ground
  double target_height_m = 0.25;                              // of the target's middle, over the ground
  double camera_x_m = 0, camera_z_m = 0;                      // in base: from where the head looks
  double speed_mps = 0.8, climb_mps = 0.5, turn_radps = 0.6;  // at most
  double accel_mps2 = 1.0;      // change of the commanded velocity: it leans as little as it can
  double gain_per_s = 0.8;      // velocity for each m to the target
  double learn_per_s2 = 0.25;   // of that, its integral: wind, and a target that moves
  double learn_within_m = 0.7;  // of the target; farther away nothing is learned
  double learn_most_mps = 0.8;
  double height_per_s = 1.0, turn_per_s = 1.0;
  double turn_from_m = 0.8;  // nearer to the target it does not turn towards it any more
  double arrived_m = 0.3;    // horizontally: over the target
  double level_rad = 0.05;   // a target that is no deeper below the horizon is as far as this says
  double farthest_m = 20;
  double stay_s = 8;  // over the target; then the mission is done, and it stays on
  double landed_m = 0.15;
};

/// Steers a vehicle with velocities to where its head looks, and over it.
///
/// The head says in which direction the target is (azimuth, elevation). The ground is flat, and the estimate's origin
/// is on it (what is below the vehicle now, the target for one, does not count): then the height says how far. The
/// target's place relative to the vehicle is that of the ray's point at the target's height. It is exact where it has
/// to be: a wrong angle counts the less the nearer the target is. The vehicle turns to the target while it is far, goes
/// straight towards it, slower the nearer it is, and stands over it. What is left then (wind, a target that moves) is
/// learned as a velocity of the air over the ground. Without a target in view it hovers, what was learned is forgotten
/// (a target that moves on may be the most of it), and the head searches.
/// Frames:  base, turned level: x forward, y left. Commands in the axes of the heading.
/// Thread:  owner.   RT: yes.
class SteerToLaw {
 public:
  SteerToParams params;

  void reset();
  void set_safety(const msg::SafetyState& safety);
  void step(msg::Time now, const msg::NavState& nav, const msg::HeadState& head, double dt_s);
  const math::Vec3& velocity_mps() const { return velocity_; }
  double turn_radps() const { return turn_; }
  const msg::MissionState& mission() const { return mission_; }
  /// Of the target's middle from base; only while a target is known.
  const math::Vec3& target_heading_m() const { return target_; }

 private:
  bool flies() const;
  bool steers() const;
  void enter(msg::MissionPhase phase, msg::Time now);
  void choose_phase(msg::Time now, const msg::NavState& nav, bool seen);
  void place_target(const msg::NavState& nav, const msg::HeadState& head);
  void fly(const msg::NavState& nav, double dt_s);

  msg::MissionState mission_;
  math::Vec3 velocity_, target_;
  math::Vec3 learned_world_mps_;
  double turn_ = 0, low_s_ = 0;  // low: below landed_m, while it descends
  msg::FailsafeAction action_ = msg::FailsafeAction::none;
  std::uint32_t permitted_ = 1;
  std::uint32_t landed_ = 0;
  [[maybe_unused]] std::uint32_t spare_ = 0;  // no padding in saved states
};

}  // namespace sinew::air_robot
