#include "robots/air_robot/hop.hpp"

#include <algorithm>
#include <cmath>

namespace sinew::air_robot {

using namespace std::chrono_literals;
using msg::MissionPhase;

void Hop::declare(rt::Declaration& d) {
  d.in("state", state_, {.max_age = 500ms});
  d.in("safety", safety_, {.optional = true, .supervises = true});
  d.out("velocity", velocity_);
  d.out("fly", fly_);
  d.out("mission", mission_);
  d.state(phase_);
  d.state(in_phase_s_);
  d.state(since_);
  d.param("height_m", height_m_, {.unit = "m", .min = 0.1, .max = 50, .doc = "of the flight"});
  d.param("forward_mps", forward_mps_, {.unit = "m/s", .min = -10, .max = 10, .doc = "of the way"});
  d.param("forward_s", forward_s_, {.unit = "s", .min = 0, .max = 600, .doc = "how long it flies forward"});
  d.param("hover_s", hover_s_, {.unit = "s", .min = 0, .max = 600, .doc = "before and behind the way"});
  d.param("climb_mps", climb_mps_, {.unit = "m/s", .min = 0.05, .max = 10, .doc = "at most, up and down"});
  d.param("gain_per_s", gain_, {.unit = "1/s", .min = 0.05, .max = 10, .doc = "vertical velocity for each m"});
  d.param("landed_m", landed_m_, {.unit = "m", .min = -5, .max = 5, .doc = "lower is on the ground"});
  d.param("limit_s", limit_s_,
          {.unit = "s", .min = 1, .max = 600, .doc = "of climb and descent; then it lands, or ends"});
  d.param("on_ground", on_ground_, {.doc = "a vehicle: no climb, no descent"});
}

void Hop::enter(MissionPhase phase, rt::Time now) {
  phase_ = phase;
  in_phase_s_ = 0;
  since_ = now;
}

bool Hop::flying() const {
  return phase_ == MissionPhase::climb || phase_ == MissionPhase::hold || phase_ == MissionPhase::approach ||
         phase_ == MissionPhase::search;
}

void Hop::plan(const msg::NavState& state, rt::Time now) {
  const msg::SafetyState* safety = safety_.get();
  const bool permitted = !safety || safety->permitted != 0;
  const bool calm = !safety || safety->action == msg::FailsafeAction::none;
  if (flying() && !calm) return enter(on_ground_ ? MissionPhase::touchdown : MissionPhase::descend, now);
  switch (phase_) {
    case MissionPhase::wait:
      if (permitted && calm && in_phase_s_ > 0.5) enter(on_ground_ ? MissionPhase::search : MissionPhase::climb, now);
      break;
    case MissionPhase::climb:
      if (state.height_m > 0.9 * height_m_) enter(MissionPhase::search, now);
      if (in_phase_s_ > limit_s_) enter(MissionPhase::descend, now);
      break;
    case MissionPhase::search:  // hovers, and looks
      if (in_phase_s_ > hover_s_) enter(MissionPhase::approach, now);
      break;
    case MissionPhase::approach:
      if (in_phase_s_ > forward_s_) enter(MissionPhase::hold, now);
      break;
    case MissionPhase::hold:
      if (in_phase_s_ > hover_s_) enter(on_ground_ ? MissionPhase::touchdown : MissionPhase::descend, now);
      break;
    case MissionPhase::descend:
      if (state.height_m < landed_m_ || in_phase_s_ > limit_s_) enter(MissionPhase::touchdown, now);
      break;
    case MissionPhase::touchdown:
      if (in_phase_s_ > 1) enter(MissionPhase::done, now);
      break;
    default:
      break;
  }
}

rt::StepStatus Hop::step(const rt::Step& step) noexcept {
  const msg::NavState* state = state_.fresh(step.now);
  if (!state) return rt::StepStatus::stale;
  in_phase_s_ += msg::seconds(step.dt);
  plan(*state, step.now);

  msg::VelocityCommand& velocity = velocity_.loan();
  velocity.stamp = state->stamp;
  if (flying() && !on_ground_)
    velocity.linear_mps.z = std::clamp(gain_ * (height_m_ - state->height_m), -climb_mps_, climb_mps_);
  if (phase_ == MissionPhase::approach) velocity.linear_mps.x = forward_mps_;
  if (phase_ == MissionPhase::descend) velocity.linear_mps.z = -climb_mps_;

  msg::ActuatorCommand& fly = fly_.loan();
  fly.stamp = state->stamp;
  fly.count = 1;
  fly.armed = phase_ == MissionPhase::done ? 0 : 1;
  fly.value[0] = flying() ? 1 : 0;

  msg::MissionState& mission = mission_.loan();
  mission.stamp = step.now;
  mission.phase_since = since_;
  mission.phase = phase_;
  return rt::StepStatus::ok;
}

}  // namespace sinew::air_robot
