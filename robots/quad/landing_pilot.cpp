#include "robots/quad/landing_pilot.hpp"

namespace sinew::control {

void LandingPilot::reset() {
  view.reset();
  velocity_mps_ = {};
  pictures_ = 0;
}

bool LandingPilot::see(const msg::PadSighting& sighting, const msg::NavState& nav) {
  view.see(sighting, nav);
  const bool due = pictures_ % params.decide_every == 0;
  ++pictures_;
  return due;
}

void LandingPilot::act(const LandingWish& wish) {
  velocity_mps_ = {};
  if (!view.known()) return;
  velocity_mps_ = {wish.aside_mps[0], wish.aside_mps[1], view.blind() ? -params.blind_sink_mps : -wish.sink_mps};
}

}  // namespace sinew::control
