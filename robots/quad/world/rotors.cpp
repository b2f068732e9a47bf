#include "robots/quad/world/rotors.hpp"

#include <algorithm>
#include <cmath>

namespace sinew::plant {

double ground_effect(double height_m, double radius_m) {
  const double ratio = radius_m / (4.0 * std::max(height_m, 0.6 * radius_m));
  return 1.0 / (1.0 - ratio * ratio);
}

Propulsion::Propulsion(const std::array<double, kRotors>& thrust_factor, double charge)
    : factor_(thrust_factor), charge_(charge) {
  voltage_ = battery_.empty_v + charge_ * (battery_.full_v - battery_.empty_v);
}

Wrench Propulsion::step(const std::array<double, kRotors>& command, double height_m, double dt_s) {
  const double speed_scale = voltage_ / battery_.nominal_v;  // a motor's top speed follows its voltage
  const double k_thrust = rotor_.thrust_max_n / (rotor_.omega_max_radps * rotor_.omega_max_radps);
  const double blend = dt_s / (rotor_.lag_s + dt_s);
  const double lift_factor = ground_effect(height_m, rotor_.radius_m);

  Wrench w;
  double shaft_w = 0;
  for (std::size_t i = 0; i < kRotors; ++i) {
    const double fraction = command[i] > 0 ? std::min(command[i], 1.0) : 0.0;  // NaN stops the motor
    const double target = rotor_.omega_max_radps * speed_scale * std::sqrt(fraction);
    const double before = omega_[i];
    omega_[i] += blend * (target - before);
    const double momentum_rate = rotor_.inertia_kgm2 * (omega_[i] - before) / dt_s;
    const double k_omega2 = k_thrust * omega_[i] * omega_[i];
    const double thrust = factor_[i] * k_omega2 * lift_factor;
    const double drag = rotor_.torque_per_thrust_m * k_omega2;
    shaft_w += drag * omega_[i];

    const RotorMount& m = kRotorMounts[i];
    w.force_n.z += thrust;
    w.torque_nm.x += m.p_base_m.y * thrust;
    w.torque_nm.y -= m.p_base_m.x * thrust;
    w.torque_nm.z -= m.spin * (drag + momentum_rate);
  }
  step_battery(shaft_w, dt_s);
  return w;
}

void Propulsion::step_battery(double shaft_w, double dt_s) {
  current_ = battery_.idle_a + shaft_w / (rotor_.efficiency * voltage_);
  charge_ = std::max(0.0, charge_ - current_ * dt_s / battery_.capacity_as);
  const double open_v = battery_.empty_v + charge_ * (battery_.full_v - battery_.empty_v);
  const double loaded_v = std::max(open_v - battery_.resistance_ohm * current_, 0.5 * battery_.empty_v);
  voltage_ += dt_s / (battery_.lag_s + dt_s) * (loaded_v - voltage_);
}

}  // namespace sinew::plant
