#include "control/excitation.hpp"

#include <algorithm>
#include <string>

#include "math/elementary.hpp"

namespace sinew::control {

using namespace std::chrono_literals;

void Excitation::declare(rt::Declaration& d) {
  d.in("joints", joints_, {.max_age = 100ms});
  d.in("safety", safety_, {.optional = true, .supervises = true});
  d.out("command", command_);
  d.state(run_);
  d.param("joints", count_, {.min = 1, .max = msg::kMaxChannels, .doc = "of the group"});
  d.param("rounds", plan_.rounds, {.min = 1, .max = 1000, .doc = "of each joint"});
  d.param("round_s", plan_.round_s, {.unit = "s", .min = 3, .max = 60, .doc = "length of a round"});
  d.param("together_s", plan_.together_s,
          {.unit = "s", .min = 0, .max = 600, .doc = "then all swing together, for base inertial parameters"});
  d.param("turn_rad", plan_.turn_rad, {.unit = "rad", .min = 0.005, .max = 0.5, .doc = "small turns, for play"});
  d.param("seed", seed_, {.min = 1, .max = 1e9, .doc = "of phases and jumps"});
  d.param("approach_radps", approach_radps_,
          {.unit = "rad/s", .min = 0.01, .max = 5, .doc = "to the centres at first"});
  for (std::size_t j = 0; j < range_.size(); ++j) {
    const std::string at = "_" + std::to_string(j);
    ExcitationRange& r = range_[j];
    d.param("centre_rad" + at, r.centre_rad,
            {.unit = "rad", .min = -6.3, .max = 6.3, .doc = "of joint " + at.substr(1)});
    d.param("reach_rad" + at, r.reach_rad, {.unit = "rad", .min = 0, .max = 3.2, .doc = "to each side; 0: it stays"});
    d.param("fast_radps" + at, r.fast_radps, {.unit = "rad/s", .min = 0.1, .max = 50, .doc = "of its swings"});
    d.param("jump_radps" + at, r.jump_radps,
            {.unit = "rad/s", .min = 0.1, .max = 1000, .doc = "of its jumps: below the guardian's rate_per_s"});
  }
}

double Excitation::setpoint_rad(std::size_t joint, double t_s) const noexcept {
  // All approach their centres for as long as the farthest needs.
  double approach_s = 0;
  for (std::size_t j = 0; j < static_cast<std::size_t>(count_); ++j)
    approach_s = std::max(approach_s, 1.5 * math::fabs(range_[j].centre_rad - run_.from_rad[j]) / approach_radps_);
  const double from = run_.from_rad[joint], centre = range_[joint].centre_rad;
  if (t_s >= approach_s)
    return plan_.target_rad(joint, static_cast<std::size_t>(count_), range_[joint], t_s - approach_s);
  const double x = t_s / approach_s;
  return from + (centre - from) * x * x * (3 - 2 * x);
}

rt::StepStatus Excitation::step(const rt::Step& step) noexcept {
  const msg::JointState* joints = joints_.fresh(step.now);
  const auto count = static_cast<std::size_t>(count_);
  if (!joints || joints->count < count) return rt::StepStatus::stale;
  for (std::size_t j = 0; j < count; ++j)
    if (!math::is_finite(joints->position_rad[j])) return rt::StepStatus::stale;
  plan_.seed = static_cast<std::uint64_t>(seed_);
  const msg::SafetyState* safety = safety_.get();
  const bool permitted = !safety || (safety->permitted != 0 && safety->action != msg::FailsafeAction::stop);
  if (!permitted) run_.begun_ns = 0;
  if (run_.begun_ns == 0) {
    for (std::size_t j = 0; j < count; ++j) run_.from_rad[j] = joints->position_rad[j];
    if (permitted) run_.begun_ns = step.now.ns;
  }
  msg::ActuatorCommand& out = command_.loan();
  out.stamp = joints->stamp;
  out.count = static_cast<std::uint32_t>(count);
  out.armed = permitted ? 1 : 0;
  const double t_s = permitted ? 1e-9 * static_cast<double>(step.now.ns - run_.begun_ns) : 0;
  for (std::size_t j = 0; j < count; ++j) out.value[j] = setpoint_rad(j, t_s);
  return rt::StepStatus::ok;
}

}  // namespace sinew::control
