#include "control/mixer.hpp"

#include "control/plausible.hpp"

namespace sinew::control {

using namespace std::chrono_literals;

void Mixer::declare(rt::Declaration& d) {
  d.in("wrench", wrench_, {.max_age = 10ms});
  d.out("motors", motors_, {.channels = 4});
  d.param("arm_x_m", rotors_.arm_x_m, {.unit = "m", .min = 0.01, .max = 5, .doc = "of a motor, along x"});
  d.param("arm_y_m", rotors_.arm_y_m, {.unit = "m", .min = 0.01, .max = 5, .doc = "of a motor, along y"});
  d.param("torque_per_thrust_m", rotors_.torque_per_thrust_m,
          {.unit = "m", .min = 1e-4, .max = 1, .doc = "a rotor's torque about its axis, by its thrust"});
  d.param("thrust_max_n", rotors_.thrust_max_n, {.unit = "N", .min = 0.01, .max = 1000, .doc = "of one rotor"});
  d.param("idle", rotors_.idle, {.unit = "1", .min = 0, .max = 0.3, .doc = "least command of a live motor"});
}

rt::StepStatus Mixer::step(const rt::Step& step) noexcept {
  const msg::WrenchSetpoint* wrench = wrench_.fresh(step.now);
  if (!wrench) return rt::StepStatus::stale;
  const double thrust_n = 4 * rotors_.thrust_max_n;  // of all; a command may ask for more, but not many times more
  const double torque_nm = 10 * thrust_n * (rotors_.arm_x_m + rotors_.arm_y_m);
  if (!within(wrench->torque_nm, torque_nm) || !within({wrench->thrust_n, 0, 0}, 10 * thrust_n))
    return rt::StepStatus::fault;
  const math::Vec3 torque(wrench->torque_nm);
  msg::ActuatorCommand& out = motors_.loan();
  out.stamp = wrench->stamp;
  out.count = 4;
  out.armed = wrench->armed;
  if (!wrench->armed) return rt::StepStatus::ok;
  const RotorAllocation a = allocate(torque, wrench->thrust_n, rotors_);
  for (std::size_t i = 0; i < a.command.size(); ++i) out.value[i] = a.command[i];
  return rt::StepStatus::ok;
}

}  // namespace sinew::control
