#include "rt/arming.hpp"

#include <algorithm>
#include <utility>

namespace sinew::rt {

using msg::FailsafeAction;

Arming::Arming(GuardianSpec::Arming mode, const std::vector<FailsafeSpec>& failsafes)
    : mode_(mode), failsafes_(failsafes), latched_at_(failsafes.size()) {}

void Arming::declare_state(Declaration& d) {
  d.state(latched_at_, permitted_, ready_, live_, held_, latched_, acted_, action_);
}

void Arming::reset() {
  permitted_ = ready_ = live_ = held_ = cut_off_ = false;
  acted_ = 0;
  disarmed_ = {};
  forget();
}

void Arming::forget() noexcept {
  latched_ = 0;
  action_ = FailsafeAction::none;
}

bool Arming::arm() noexcept {
  if (permitted_ || ready_) {
    permitted_ = true;
    held_ = false;
  }
  return permitted_;
}

void Arming::disarm() noexcept {
  cut_off_ = cut_off_ || live_;
  permitted_ = ready_ = live_ = false;
  held_ = true;
  forget();
}

/// In flight: what holds is latched, and asks for the worst of what is configured.
void Arming::act(const Facts& facts) noexcept {
  for (std::size_t i = 0; i < failsafes_.size(); ++i) {
    const std::uint32_t bit = 1u << i;
    const FailsafeSpec& f = failsafes_[i];
    if ((facts.conditions & bit) && !(latched_ & bit)) {
      latched_ |= bit;
      latched_at_[i] = facts.now;
      action_ = std::max(action_, f.action);
    }
    if ((latched_ & bit) && f.stop_after && facts.now - latched_at_[i] >= *f.stop_after) action_ = FailsafeAction::stop;
  }
  acted_ |= latched_;
  if (action_ == FailsafeAction::stop) permitted_ = false;
}

void Arming::step(const Facts& facts) noexcept {
  if (std::exchange(cut_off_, false)) disarmed_ = facts.now;
  const bool was_live = live_;
  live_ = permitted_ && facts.commanded;
  if (live_)
    act(facts);
  else if (permitted_ && (was_live || facts.conditions))
    permitted_ = false;
  const bool automatic = mode_ == GuardianSpec::Arming::automatic;
  if (automatic && !facts.commanded) forget();
  ready_ = !facts.conditions && !latched_ && facts.groups_good && (facts.idle || !wants_idle());
  if (automatic && !held_ && ready_) permitted_ = true;
  live_ = permitted_ && facts.commanded;
}

}  // namespace sinew::rt
