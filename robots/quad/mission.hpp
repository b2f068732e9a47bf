#pragma once
#include "msg/pilot.hpp"
#include "msg/place.hpp"
#include "robots/quad/mission_plan.hpp"
#include "rt/module.hpp"

namespace sinew::control {

/// Flies to the landing pad and lands on it: arm, climb, search, approach, hold, descend, touch down, disarm. See
/// MissionPlan. With `safety` bound it arms only when the guardian permits it, and lands where it is when a failsafe
/// asks for that. With `after_mate` it waits on the ground until the mate whose mission is `ahead` has landed, or is
/// not heard any more; with `told_pad` bound it searches where a mate has seen the pad. With `guided` the velocity
/// that comes in `guide` takes the place of approach, hold and descent. With `pilot` bound it stands by
/// while a pilot flies by hand, and comes down where it is afterwards. Thread:  executor, 100 to 250 Hz, before the
/// position controller.   RT: yes. Errors:  stale without a fresh state: nothing is published, the loops below follow,
/// and the guardian acts when the
///          lease of the last command runs out.
class Mission final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  void reset() override { plan_.reset(); }
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  rt::In<msg::NavState> state_;
  rt::In<msg::SafetyState> safety_;
  rt::In<msg::PilotSwitches> pilot_;
  rt::In<msg::MissionState> ahead_;
  rt::In<msg::PlaceEstimate> told_pad_;
  rt::In<msg::FlightSetpoint> guide_;
  rt::Out<msg::FlightSetpoint> setpoint_;
  rt::Out<msg::MissionState> mission_;
  bool after_mate_ = false, guided_ = false;
  MissionPlan plan_;
};

}  // namespace sinew::control
