#pragma once
#include <memory>
#include <string>

#include "robots/quad/landing_pilot.hpp"
#include "rt/module.hpp"

namespace sinew::control {

/// Lands by a policy that `sinew-learn` has learned, on what the camera sees: offset and size of the pad, and their
/// rates. It commands a velocity; the mission flies it instead of its own descent (Mission's input `guide`), so limits,
/// position loop and guardian are behind it as behind everything else. See LandingPolicy, LandingView, LandingPilot.
/// The policy is a file of parameters, which `sinew run --params` reads; `aside` and `down` are its weights.
/// Frames:  world of NavState, z up.
/// Thread:  executor, once for each picture.   RT: yes.
/// Errors:  configure() fails without weights, or with others than the actions need. stale without a new sighting or a
///          fresh state; fault when these are no numbers. Nothing is published then, and the mission hovers.
class LearnedLanding final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  hal::Status configure(rt::Setup& setup) override;
  void reset() override { pilot_.reset(); }
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  rt::In<msg::PadSighting> sighting_;
  rt::In<msg::NavState> state_;
  rt::Out<msg::FlightSetpoint> guide_;
  std::string actions_ = "continuous", aside_, down_;
  LandingPilot pilot_;
  std::unique_ptr<LandingPolicy> policy_;
};

}  // namespace sinew::control
