#include "control/attitude_controller.hpp"

#include "control/limits.hpp"
#include "control/plausible.hpp"

namespace sinew::control {

using namespace std::chrono_literals;

void AttitudeController::declare(rt::Declaration& d) {
  d.in("state", state_, {.max_age = 10ms});
  d.in("attitude", attitude_, {.max_age = 50ms});
  d.out("wrench", wrench_);
  d.state(law_, tipped_s_, tipped_);
  AttitudeParams& p = law_.params;
  d.param("kp_tilt", p.kp_tilt, {.unit = "1/s", .min = 0, .max = 50, .doc = "turning rate for each rad of tilt error"});
  d.param("kp_yaw", p.kp_yaw,
          {.unit = "1/s", .min = 0, .max = 50, .doc = "turning rate for each rad of heading error"});
  d.param("rate_tilt_radps", p.rate_tilt_radps,
          {.unit = "rad/s", .min = 0.1, .max = 50, .doc = "fastest turn that tilts"});
  d.param("rate_yaw_radps", p.rate_yaw_radps,
          {.unit = "rad/s", .min = 0.1, .max = 50, .doc = "fastest turn of the heading"});
  d.param("kp_rate", p.kp_rate,
          {.unit = "1/s",
           .min = 0,
           .max = 200,
           .doc = "angular acceleration for each rad/s of rate error, roll and pitch"});
  d.param("kp_rate_yaw", p.kp_rate_yaw, {.unit = "1/s", .min = 0, .max = 200, .doc = "the same about the vertical"});
  d.param("ki_rate", p.ki_rate,
          {.unit = "1/s^2", .min = 0, .max = 1000, .doc = "the same for the sum of the rate error, roll and pitch"});
  d.param("ki_rate_yaw", p.ki_rate_yaw, {.unit = "1/s^2", .min = 0, .max = 1000, .doc = "the same about the vertical"});
  d.param("kd_rate", p.kd_rate,
          {.unit = "1",
           .min = 0,
           .max = 5,
           .doc = "share of the measured angular acceleration that is taken back: damping"});
  d.param("d_cutoff_hz", p.d_cutoff_hz,
          {.unit = "Hz", .min = 1, .max = 500, .doc = "low-pass of that angular acceleration"});
  d.param("integral_radps2", p.integral_radps2,
          {.unit = "rad/s^2", .min = 0, .max = 500, .doc = "most that the sum may add, roll and pitch"});
  d.param("integral_yaw_radps2", p.integral_yaw_radps2,
          {.unit = "rad/s^2", .min = 0, .max = 500, .doc = "the same about the vertical"});
  d.param("inertia_x_kgm2", p.inertia_kgm2.x,
          {.unit = "kg m^2", .min = 1e-6, .max = 100, .doc = "of the vehicle, about its x"});
  d.param("inertia_y_kgm2", p.inertia_kgm2.y, {.unit = "kg m^2", .min = 1e-6, .max = 100, .doc = "about its y"});
  d.param("inertia_z_kgm2", p.inertia_kgm2.z, {.unit = "kg m^2", .min = 1e-6, .max = 100, .doc = "about its z"});
  d.param("tipped_tilt_rad", tipped_tilt_rad_, {.unit = "rad", .min = 0.1, .max = 3.2, .doc = "3.2: never tipped"});
  d.param(
      "tipped_after_s", tipped_after_s_,
      {.unit = "s", .min = 0, .max = 10, .doc = "tilted by more for so long: tipped over, no commands until disarmed"});
}

void AttitudeController::reset() {
  law_.reset();
  tipped_s_ = 0;
  tipped_ = false;
}

bool AttitudeController::has_tipped(const msg::NavState& state, bool armed, double dt_s) {
  const double up_z = math::Quat(state.q_world_base).rotate({0, 0, 1}).z;  // cosine of the tilt
  tipped_s_ = up_z < math::cos(tipped_tilt_rad_) ? tipped_s_ + dt_s : 0;
  tipped_ = armed && (tipped_ || tipped_s_ > tipped_after_s_);
  return tipped_;
}

rt::StepStatus AttitudeController::step(const rt::Step& step) noexcept {
  const msg::NavState* state = state_.fresh(step.now);
  const msg::AttitudeSetpoint* wanted = attitude_.fresh(step.now);
  if (!state || !wanted || !state->attitude_valid) return rt::StepStatus::stale;
  if (!plausible(*state) || !plausible(*wanted)) return rt::StepStatus::fault;
  if (has_tipped(*state, wanted->armed != 0, step_seconds(step.dt))) return rt::StepStatus::fault;
  const msg::WrenchSetpoint wrench = law_.step(*state, *wanted, step_seconds(step.dt));
  if (!is_finite(math::Vec3(wrench.torque_nm))) return rt::StepStatus::fault;
  wrench_.loan() = wrench;
  return rt::StepStatus::ok;
}

}  // namespace sinew::control
