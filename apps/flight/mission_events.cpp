#include "apps/flight/mission_events.hpp"

#include <fmt/format.h>

#include <utility>

#include "robots/robot_kind.hpp"
#include "rt/safety_text.hpp"

namespace sinew::app {
namespace {

Story::Weight weight_of(msg::MissionPhase phase) {
  using P = msg::MissionPhase;
  if (phase == P::wait || phase == P::arm) return Story::Weight::detail;
  return phase == P::done || phase == P::abort ? Story::Weight::result : Story::Weight::phase;
}

const char* action_text(msg::FailsafeAction action) { return action == msg::FailsafeAction::stop ? "stop" : "land"; }

const char* safe_text(rt::ActuatorSpec::Safe safe) {
  using S = rt::ActuatorSpec::Safe;
  switch (safe) {
    case S::stop:
      return "stop";
    case S::hold:
      return "hold";
    case S::damp:
      return "damp";
    case S::torque_off:
      return "torque off";
  }
  return "?";
}

/// Why a group went to its safe action, of the first fault that says so.
std::string fault_text(std::uint32_t faults, const rt::ActuatorSpec& a) {
  if (faults & msg::kFaultDevice) return "the device refuses commands";
  if (faults & msg::kFaultCount) return "commands on " + a.command.value + " with a wrong number of channels";
  if (faults & msg::kFaultNotFinite) return "commands on " + a.command.value + " are not finite";
  if (faults & msg::kFaultLimit) return "commands on " + a.command.value + " beyond the limit";
  if (faults & msg::kFaultLease)
    return fmt::format("no valid command on {} for {:g} ms", a.command.value, 1e3 * msg::seconds(a.lease));
  return "commands do not pass";
}

/// Of missions that have no words of their own.
const char* words_of_all(msg::MissionPhase phase) {
  using P = msg::MissionPhase;
  switch (phase) {
    case P::wait:
      return "waiting";
    case P::arm:
      return "arming";
    case P::climb:
      return "climbing";
    case P::search:
      return "searching";
    case P::approach:
      return "approaching";
    case P::hold:
      return "holding";
    case P::descend:
      return "descending";
    case P::touchdown:
      return "touching down";
    case P::done:
      return "done";
    case P::abort:
      return "aborted";
  }
  return "?";
}

}  // namespace

void MissionEvents::see(const msg::MissionState& state) {
  if (phase_ == state.phase) return;
  phase_ = state.phase;
  events_.push_back({state.phase_since, weight_of(state.phase), phase_words(*spec_, state.phase)});
}

void MissionEvents::see(const msg::SafetyState& state) {
  const msg::SafetyState before = std::exchange(safety_, state);
  const auto add = [&](rt::Time at, Story::Weight weight, std::string text) {
    events_.push_back({at, weight, std::move(text), weight == Story::Weight::result});
  };
  for (std::size_t i = 0; i < spec_->failsafes.size(); ++i) {
    const rt::FailsafeSpec& f = spec_->failsafes[i];
    // What latched and was disarmed between two messages still shows as acted.
    const std::uint32_t acts = (state.latched & ~before.latched) | (state.acted & ~before.acted);
    if (acts >> i & 1)
      add(state.stamp, Story::Weight::result,
          fmt::format("{}: {} -> {}", f.name, rt::cause_text(f, state.measured[i]), action_text(f.action)));
  }
  const bool none_new = (state.latched & ~before.latched) == 0;
  if (none_new && before.action == msg::FailsafeAction::land && state.action == msg::FailsafeAction::stop)
    add(state.stamp, Story::Weight::result, "the landing took too long -> stop");
  if (state.disarmed > before.disarmed)
    add(state.disarmed, Story::Weight::result, "disarmed, while the actuators were live");
  else if (spec_->guardian.arming == rt::GuardianSpec::Arming::manual && state.permitted != before.permitted)
    add(state.stamp, Story::Weight::phase, state.permitted ? "armed" : "not armed any more");
}

void MissionEvents::see(std::size_t actuator, const msg::GuardianState& state) {
  const rt::ActuatorSpec& spec = spec_->actuators[actuator];
  const msg::GuardianMode before = std::exchange(modes_[actuator], state.mode);
  const bool was_live = before == msg::GuardianMode::active || before == msg::GuardianMode::armed;
  // Of a failsafe the guardian's own state tells.
  if (state.mode == msg::GuardianMode::safe && was_live && !(state.faults & msg::kFaultFailsafe))
    events_.push_back({state.stamp, Story::Weight::result,
                       fmt::format("{}: {} -> {}", spec.name, fault_text(state.faults, spec), safe_text(spec.safe)),
                       true});
  if (state.mode == msg::GuardianMode::active && before == msg::GuardianMode::safe)
    events_.push_back({state.stamp, Story::Weight::phase, spec.name + ": commands pass again"});
}

std::vector<MissionEvents::Event> MissionEvents::take() { return std::exchange(events_, {}); }

std::string phase_words(const rt::GraphSpec& spec, msg::MissionPhase phase) {
  for (const rt::ModuleSpec& module : spec.modules)
    if (const std::string_view own = robots::find_phase_words(module.type, phase); module.enabled && !own.empty())
      return std::string(own);
  return words_of_all(phase);
}

}  // namespace sinew::app
