#pragma once
#include "robots/quad/world/vehicle.hpp"

namespace sinew::plant {

struct Wrench {
  msg::Vec3 force_n, torque_nm;  // base frame, at the centre of mass
};

/// Four motors on one battery.
class Propulsion {
 public:
  Propulsion(const std::array<double, kRotors>& thrust_factor, double charge);

  /// One plant step. `command` in 0..1 (clamped); heights of the rotors above the floor feed the ground effect.
  Wrench step(const std::array<double, kRotors>& command, double height_m, double dt_s);

  const std::array<double, kRotors>& omega_radps() const { return omega_; }
  double voltage_v() const { return voltage_; }
  double current_a() const { return current_; }
  double charge() const { return charge_; }  // 0..1

 private:
  void step_battery(double shaft_w, double dt_s);

  RotorParams rotor_;
  BatteryParams battery_;
  std::array<double, kRotors> factor_;
  std::array<double, kRotors> omega_{};
  double charge_;  // 0..1
  double voltage_;
  double current_ = 0;
};

/// Factor on thrust near the floor (at least 1). Source: Cheeseman and Bennett 1955, bounded below one radius.
double ground_effect(double height_m, double radius_m);

}  // namespace sinew::plant
