// What a servo is like, from a record of its commands and positions. Here the record is made by a model with known
// numbers; a robot's comes from `sinew run`, and `sinew identify` reads it.
#include <cstdio>

#include "control/excitation_plan.hpp"
#include "identify/servo_fit.hpp"

using namespace sinew;

int main() {
  identify::ServoModel servo{.delay_s = 0.024, .gain_per_rad = 4.6, .stall_nm = 4.1, .no_load_radps = 4.8};
  servo.inertia_kgm2 = 0.02, servo.rotor_kgm2 = 0.0045, servo.coulomb_nm = 0.1, servo.gravity_sin_nm = -0.5;
  servo.play_rad = 0.25 * math::kPi / 180;

  control::ExcitationPlan plan;
  plan.rounds = 4;
  identify::ServoRecord record;
  for (double t = 0; t < plan.whole_s(1); t += 0.008) {
    record.commands.time_s.push_back(t);
    record.commands.target_rad.push_back(plan.target_rad(0, 1, {.centre_rad = 0, .reach_rad = 0.7}, t));
    record.time_s.push_back(t + 0.003);
  }
  record.position_rad.resize(record.time_s.size());
  record.effort_nm.resize(record.time_s.size());
  servo.run(record.commands, {}, record.time_s, record.position_rad, record.effort_nm);
  for (double& q : record.position_rad) q = math::round(q * 4096 / (2 * math::kPi)) * 2 * math::kPi / 4096;

  const identify::ServoFit fit = identify::fit_servo(record, {.parts = 3, .step_s = 5e-4, .encoder_at_motor = false});
  if (!fit.problem.empty()) return std::fprintf(stderr, "%s\n", fit.problem.c_str()), 1;
  for (std::size_t i = 0; i < identify::kServoParameters; ++i) {
    const auto& text = identify::servo_parameters()[i];
    if (fit.estimates[i].state == identify::ServoEstimate::State::identified)
      std::printf("%-14s %9.5f +- %-9.5f %-10s was %.5f\n", text.name.data(), fit.estimates[i].value,
                  fit.estimates[i].half_width, text.unit.data(), servo.*text.value);
  }
  std::printf("off by %.2f mrad RMS in the part held out\n", 1e3 * fit.held_out.position_rad);
  return math::fabs(fit.model.delay_s - servo.delay_s) < 1e-3 ? 0 : 1;
}
