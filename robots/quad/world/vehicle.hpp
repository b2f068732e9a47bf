#pragma once
// The vehicle's numbers, in one place. Mass, inertia and shape are in robots/quad/world/room.xml.
#include <array>
#include <cstddef>

#include "msg/geometry.hpp"
#include "robots/quad/devices.hpp"

namespace sinew::plant {

struct RotorMount {
  msg::Vec3 p_base_m;
  double spin;  // +1: turns counter-clockwise seen from above, so its drag turns the vehicle clockwise (-z)
};

/// Order of the motors in every command, X configuration, arm 0.17 m (hub to hub 0.34 m).
/// Frames:  base, x forward, y left, z up.
///
///        front (+x)
///      2 cw    0 ccw        roll  torque (+x) =  l (T1 + T2 - T0 - T3)
///   (+y) left    right      pitch torque (+y) =  l (T1 + T3 - T0 - T2)
///      1 ccw   3 cw         yaw   torque (+z) =  c (T2 + T3 - T0 - T1)
///                           with l = 0.12021 m and c = 0.016 m
inline constexpr double kArm = 0.12020815280171307;  // 0.17 m / sqrt 2
inline constexpr std::array<RotorMount, kRotors> kRotorMounts{{
    {{+kArm, -kArm, 0.03}, +1.0},  // 0 front right
    {{-kArm, +kArm, 0.03}, +1.0},  // 1 rear left
    {{+kArm, +kArm, 0.03}, -1.0},  // 2 front left
    {{-kArm, -kArm, 0.03}, -1.0},  // 3 rear right
}};

/// One motor with its 9 inch propeller. A command in 0..1 is the wanted fraction of the full static thrust (the speed
/// controller is linearised: it turns at omega_max * sqrt(command)); hover is about 0.49 of it.
struct RotorParams {
  double thrust_max_n = 6.0;     // at nominal voltage and full command: thrust / weight = 2.04
  double omega_max_radps = 950;  // 9 070 rpm; k = thrust_max / omega_max^2 = 6.65e-6 N s^2
  double lag_s = 0.025;          // first order, of the speed
  double torque_per_thrust_m = 0.016;
  double inertia_kgm2 = 2.0e-5;  // rotor and propeller; its change of speed turns the body
  double radius_m = 0.115;
  double efficiency = 0.7;  // shaft power per electrical power
};

/// Forces of the air on body and rotors, against the velocity relative to the air.
struct DragParams {
  msg::Vec3 linear_n_per_mps{0.28, 0.28, 0.12};  // blade flapping and induced drag; base axes
  msg::Vec3 quadratic_n_per_m2ps2{0.06, 0.06, 0.10};
  msg::Vec3 angular_nm_per_radps{0.004, 0.004, 0.002};
};

/// 4S 3000 mAh: open-circuit voltage falls linearly with charge, terminal voltage with current.
struct BatteryParams {
  double nominal_v = 15.2;
  double full_v = 16.6, empty_v = 13.6;  // open circuit, of the usable range
  double resistance_ohm = 0.035;
  double capacity_as = 3.0 * 3600;
  double idle_a = 0.6;  // electronics
  double lag_s = 0.02;  // of the terminal voltage
};

/// Where sensors sit. The camera looks down; the top of its image is forward.
/// Frames:  camera_optical: z forward (down), x right (-y of base), y down (-x of base).
inline constexpr msg::Vec3 kCameraPBase{0, 0, -0.04};
inline constexpr msg::Quat kCameraQBaseOptical{0, 0.70710678118654752, -0.70710678118654752, 0};
inline constexpr msg::Vec3 kRangePBase{0, 0, -0.04};
inline constexpr double kFeetBelowBase = 0.12;

inline constexpr double kPadRadius = 0.30;  // centre at the world's origin

}  // namespace sinew::plant
