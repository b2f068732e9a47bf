#pragma once
#include <array>

#include "math/linear.hpp"

namespace sinew::control {

/// The rotors; the module Mixer gives each number its range.
struct RotorParams {
  double arm_x_m = 0.1202, arm_y_m = 0.1202;  // of a motor from the centre of mass, along x and y
  double torque_per_thrust_m = 0.016;         // drag torque about z
  double thrust_max_n = 6.0;                  // of one rotor at command 1
  double idle = 0.03;                         // command of a live motor that has nothing to do
};

/// Torque and thrust to four commands, each the wanted fraction of a rotor's full thrust.
/// Frames:  base. Order of the rotors: front right, rear left (both counter-clockwise seen from above), front left,
///          rear right (both clockwise).
/// Saturation: commands never leave idle..1. Roll and pitch come first: scaled down together, and only when their
///          spread alone does not fit; then the thrust, moved as far as roll and pitch need it; then as much yaw as
///          is left.
/// Thread:  any.   RT: yes.
struct RotorAllocation {
  std::array<double, 4> command{};
  double tilt_share = 1, yaw_share = 1;  // how much of the wanted torque fitted
  double thrust_n = 0;                   // what the commands give
};

RotorAllocation allocate(const math::Vec3& torque_nm, double thrust_n, const RotorParams& rotors);

}  // namespace sinew::control
