#include "control/position_controller.hpp"

#include "control/limits.hpp"
#include "control/plausible.hpp"

namespace sinew::control {

using namespace std::chrono_literals;

void PositionController::declare(rt::Declaration& d) {
  d.in("state", state_, {.max_age = 20ms});
  d.in("setpoint", setpoint_, {.max_age = 100ms});
  d.out("attitude", attitude_);
  d.state(law_);
  PositionParams& p = law_.params;
  d.param("mass_kg", p.mass_kg,
          {.unit = "kg", .min = 0.05, .max = 50, .doc = "of the vehicle; its weight is carried without any error"});
  d.param("kp_xy", p.kp_xy, {.unit = "1/s", .min = 0, .max = 10, .doc = "velocity for each m off the place"});
  d.param("kp_z", p.kp_z, {.unit = "1/s", .min = 0, .max = 10, .doc = "the same, vertical"});
  d.param("kv_xy", p.kv_xy, {.unit = "1/s", .min = 0, .max = 20, .doc = "acceleration for each m/s off the velocity"});
  d.param("kv_z", p.kv_z, {.unit = "1/s", .min = 0, .max = 20, .doc = "the same, vertical"});
  d.param("ki_xy", p.ki_xy,
          {.unit = "1/s^2",
           .min = 0,
           .max = 20,
           .doc = "acceleration for each m of summed velocity error: learns the wind"});
  d.param("ki_z", p.ki_z, {.unit = "1/s^2", .min = 0, .max = 20, .doc = "the same, vertical: learns the weight"});
  d.param("integral_xy_mps2", p.integral_xy_mps2,
          {.unit = "m/s^2", .min = 0, .max = 10, .doc = "most that the sum may add"});
  d.param("integral_z_mps2", p.integral_z_mps2, {.unit = "m/s^2", .min = 0, .max = 10, .doc = "the same, vertical"});
  d.param("speed_xy_mps", p.speed_xy_mps, {.unit = "m/s", .min = 0.05, .max = 30, .doc = "fastest horizontal flight"});
  d.param("climb_mps", p.climb_mps, {.unit = "m/s", .min = 0.05, .max = 20, .doc = "fastest climb"});
  d.param("sink_mps", p.sink_mps, {.unit = "m/s", .min = 0.05, .max = 20, .doc = "fastest descent"});
  d.param("tilt_rad", p.tilt_rad, {.unit = "rad", .min = 0.02, .max = 1.0, .doc = "largest tilt"});
  d.param("thrust_min_n", p.thrust_min_n, {.unit = "N", .min = 0.01, .max = 500, .doc = "least thrust in flight"});
  d.param("thrust_max_n", p.thrust_max_n,
          {.unit = "N", .min = 0.1, .max = 2000, .doc = "most thrust; height comes before place"});
  d.param("blind_thrust_share", p.blind_thrust_share, {.unit = "1", .min = 0.5, .max = 1, .doc = "of the weight"});
}

rt::StepStatus PositionController::step(const rt::Step& step) noexcept {
  const msg::NavState* state = state_.fresh(step.now);
  const msg::FlightSetpoint* wanted = setpoint_.fresh(step.now);
  if (!state || !wanted || !state->attitude_valid) return rt::StepStatus::stale;
  if (!plausible(*state) || !plausible(*wanted)) return rt::StepStatus::fault;
  attitude_.loan() = law_.step(*state, *wanted, step_seconds(step.dt));
  return rt::StepStatus::ok;
}

}  // namespace sinew::control
