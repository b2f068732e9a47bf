#include "sim_hil/places/vehicle_kind.hpp"

namespace sinew::plant {
namespace {

// Across 80 degrees of a picture of 4 : 3 (USARCamera's CameraFOV of 1.3963 rad).
constexpr double kUsarFocalPerHeight = 0.5 / 0.83909963117728 * 4 / 3;

constexpr VehicleKind pioneer(const char* name) {
  VehicleKind k;
  k.name = name;
  k.locomotion = Locomotion::wheels;
  k.mass_kg = 12;
  k.rest_m = 0.16;
  k.hull_radius_m = 0.22, k.hull_up_m = 0.17;
  k.size_m = {0.50, 0.49, 0.26};
  k.wheel_radius_m = 0.11, k.track_m = 0.40, k.wheelbase_m = 0.27;
  k.wheel_radps = 6.4, k.wheel_lag_s = 0.10;
  k.step_m = 0.09, k.slope_rad = 0.45;
  k.camera_p_base_m = {0.12, 0, 0.24};
  k.pan_rad = 2.6, k.tilt_up_rad = 0.5, k.tilt_down_rad = 1.2, k.camera_radps = 1.5;
  k.focal_per_height = kUsarFocalPerHeight;
  k.battery_s = 1200, k.battery_full_v = 12.8, k.battery_empty_v = 11.2, k.battery_a = 6;
  return k;
}

constexpr VehicleKind steered(const char* name) {
  VehicleKind k = pioneer(name);
  k.rest_m = 0.20;
  k.wheel_radius_m = 0.128;
  k.wheel_radps = 8, k.wheel_lag_s = 0.20;
  k.steer_radps = 1.5;
  return k;
}

constexpr VehicleKind front_steered() {
  VehicleKind k = steered("front_ackerman");
  k.mass_kg = 145;
  k.hull_radius_m = 0.45, k.hull_up_m = 0.36;
  k.size_m = {1.21, 0.54, 0.45};
  k.wheelbase_m = 0.956, k.track_m = 0.45;
  k.front_steer_rad = 0.5;
  k.camera_p_base_m = {0.40, 0, 0.30};
  return k;
}

constexpr VehicleKind rear_steered() {
  VehicleKind k = steered("basic_ackerman");
  k.mass_kg = 14;
  k.hull_radius_m = 0.40, k.hull_up_m = 0.31;
  k.size_m = {0.86, 0.66, 0.40};
  k.wheelbase_m = 0.60, k.track_m = 0.576;
  k.rear_steer_rad = 0.8;
  k.camera_p_base_m = {0.25, 0, 0.30};
  return k;
}

constexpr VehicleKind air_robot() {
  VehicleKind k;
  k.name = "air_robot";
  k.locomotion = Locomotion::rotors;
  k.mass_kg = 1.0;
  k.rest_m = 0.12;
  k.hull_radius_m = 0.32, k.hull_up_m = 0.20;
  k.size_m = {0.62, 0.62, 0.18};
  k.speed_mps = 5, k.climb_mps = 3, k.turn_radps = 2.5;
  k.lag_s = 0.20, k.accel_mps2 = 5, k.drag_per_s = 0.35;
  k.camera_p_base_m = {0.14, 0, -0.05};
  k.pan_rad = 2.8, k.tilt_up_rad = 0.6, k.tilt_down_rad = 1.9, k.camera_radps = 2.5;
  k.focal_per_height = kUsarFocalPerHeight;
  k.battery_s = 1200, k.battery_full_v = 16.6, k.battery_empty_v = 13.6, k.battery_a = 9;
  return k;
}

}  // namespace

constinit const VehicleKind kAirRobot = air_robot(), kP3at = pioneer("p3at"), kP2at = pioneer("p2at"),
                            kFrontSteered = front_steered(), kRearSteered = rear_steered();

}  // namespace sinew::plant
