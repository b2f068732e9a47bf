#pragma once
// The kinds of vehicles that a place knows, each as one table of numbers.
#include <cstdint>
#include <span>
#include <string_view>

#include "math/linear.hpp"

namespace sinew::plant {

enum class Locomotion : std::uint8_t { rotors, wheels };

/// Frames:  base: x forward, y left, z up; of a vehicle that stands, base is rest_m over the ground.
struct VehicleKind {
  const char* name = "";
  Locomotion locomotion = Locomotion::rotors;
  double mass_kg = 0;
  double rest_m = 0;                        // height of base over the ground, at rest
  double hull_radius_m = 0, hull_up_m = 0;  // a ball over base: what touches walls and other vehicles
  math::Vec3 size_m;                        // as it is drawn

  // ---- rotors: velocities are commanded, in the axes of its heading
  double speed_mps = 0, climb_mps = 0, turn_radps = 0;  // the most that it obeys
  double lag_s = 0, accel_mps2 = 0;                     // of the velocity: first order, and its limit
  double drag_per_s = 0;                                // it leans against drag: acceleration for each m/s
  // ---- wheels: their spin is commanded, left and right
  double wheel_radius_m = 0, track_m = 0, wheelbase_m = 0;
  double wheel_radps = 0, wheel_lag_s = 0;
  double step_m = 0;     // the highest edge that its wheels climb
  double slope_rad = 0;  // the steepest slope
  // ---- steered wheels: all are driven at one spin, and the wheels of an axle turn together; 0: that axle does not
  // steer
  double front_steer_rad = 0, rear_steer_rad = 0;  // the most, to either side
  double steer_radps = 0;                          // how fast they turn
  bool steers() const { return front_steer_rad > 0 || rear_steer_rad > 0; }

  // ---- its camera, on pan and tilt
  math::Vec3 camera_p_base_m;
  double pan_rad = 0, tilt_up_rad = 0, tilt_down_rad = 0;  // from straight ahead, to either side
  double camera_radps = 0;
  double focal_per_height = 0;

  double battery_s = 0, battery_full_v = 0, battery_empty_v = 0, battery_a = 0;
};

/// A quadrotor with a camera that looks ahead. Source: altURI's captured session (base rests low, 20 minutes of
/// battery); robocup-usarsim, AirRobot.uc (0.35 m from side to side between hubs) and DefaultUSAR.ini
/// (USARCamera: 80 degrees across); lag and limits of a vehicle of 1 kg.
extern const VehicleKind kAirRobot;
/// A Pioneer 3-AT: four driven wheels, skid-steered. Source: Pioneer 3 Operations Manual (0.7 m/s, climbs 35 %, steps
/// of 0.1 m, wheels of 0.22 m); robots/air_robot/p3at.toml (track of 0.40 m, as its wheels slip).
extern const VehicleKind kP3at;
/// Its predecessor, of the same size.
extern const VehicleKind kP2at;
/// A vehicle that its front wheels steer, 0.96 m from axle to axle. Source: robocup-usarsim, FrontAckerman.uc (wheels,
/// mass, 0.5 rad); its speed of 1 m/s and what it climbs are a Pioneer's.
extern const VehicleKind kFrontSteered;
/// One that its rear wheels steer. Source: BasicAckermanRobot.uc (0.6 m from axle to axle, mass, 0.8 rad), but its
/// track is half of that one's 1.15 m, so that eight of them find room.
extern const VehicleKind kRearSteered;

}  // namespace sinew::plant
