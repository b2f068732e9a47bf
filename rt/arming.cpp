#include "rt/arming.hpp"

#include <algorithm>
#include <utility>

namespace sinew::rt {

using msg::FailsafeAction;

Arming::Arming(GuardianSpec::Arming mode, const std::vector<FailsafeSpec>& failsafes)
    : mode_(mode), failsafes_(failsafes), latched_at_(failsafes.size()) {}

void Arming::declare_state(Declaration& d) { d.state(is_, latched_at_); }

void Arming::reset() { is_ = {}; }

void Arming::forget() noexcept {
  is_.latched = 0;
  is_.action = FailsafeAction::none;
}

bool Arming::arm() noexcept {
  if (is_.permitted || is_.ready) {
    is_.permitted = true;
    is_.held = false;
  }
  return is_.permitted;
}

void Arming::disarm() noexcept {
  is_.cut_off = is_.cut_off || is_.live;
  is_.permitted = is_.ready = is_.live = false;
  is_.held = true;
  forget();
}

/// In flight: latches the conditions that hold, and takes the most severe of their configured actions.
void Arming::act(const Facts& facts) noexcept {
  for (std::size_t i = 0; i < failsafes_.size(); ++i) {
    const std::uint32_t bit = 1u << i;
    const FailsafeSpec& f = failsafes_[i];
    if ((facts.conditions & bit) && !(is_.latched & bit)) {
      is_.latched |= bit;
      latched_at_[i] = facts.now;
      is_.action = std::max(is_.action, f.action);
    }
    if ((is_.latched & bit) && f.stop_after && facts.now - latched_at_[i] >= *f.stop_after)
      is_.action = FailsafeAction::stop;
  }
  is_.acted |= is_.latched;
  if (is_.action == FailsafeAction::stop) is_.permitted = false;
}

void Arming::step(const Facts& facts) noexcept {
  if (std::exchange(is_.cut_off, false)) is_.disarmed = facts.now;
  const bool was_live = is_.live;
  is_.live = is_.permitted && facts.commanded;
  if (is_.live)
    act(facts);
  else if (is_.permitted && (was_live || facts.conditions))
    is_.permitted = false;
  const bool automatic = mode_ == GuardianSpec::Arming::automatic;
  if (automatic && !facts.commanded) forget();
  is_.ready = !facts.conditions && !is_.latched && facts.groups_good && (facts.idle || !wants_idle());
  if (automatic && !is_.held && is_.ready) is_.permitted = true;
  is_.live = is_.permitted && facts.commanded;
}

}  // namespace sinew::rt
