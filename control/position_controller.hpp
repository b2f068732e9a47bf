#pragma once
#include "control/position_law.hpp"
#include "rt/module.hpp"

namespace sinew::control {

/// Turns the mission's position or velocity into attitude and thrust. See PositionLaw.
/// Thread:  executor, 100 to 250 Hz.   RT: yes.
/// Errors:  stale without a fresh state or setpoint; fault when the setpoint is not finite. Nothing is published then.
class PositionController final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  void reset() override { law_.reset(); }
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  rt::In<msg::NavState> state_;
  rt::In<msg::FlightSetpoint> setpoint_;
  rt::Out<msg::AttitudeSetpoint> attitude_;
  PositionLaw law_;
};

}  // namespace sinew::control
