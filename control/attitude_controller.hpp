#pragma once
#include "control/attitude_law.hpp"
#include "rt/module.hpp"

namespace sinew::control {

/// Turns attitude and thrust into torque and thrust, through the rates of the body. See AttitudeLaw.
/// Thread:  executor, at the rate of the state (500 to 1000 Hz).   RT: yes.
/// Errors:  stale without a fresh state or setpoint; fault when an input is not finite, and, until disarmed, once the
///          vehicle has tipped over: it is out of control then, and turning rotors only make it worse. Nothing is
///          published, and the guardian acts when the lease of the last command runs out.
class AttitudeController final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  void reset() override;
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  bool has_tipped(const msg::NavState& state, bool armed, double dt_s);
  rt::In<msg::NavState> state_;
  rt::In<msg::AttitudeSetpoint> attitude_;
  rt::Out<msg::WrenchSetpoint> wrench_;
  AttitudeLaw law_;
  double tipped_tilt_rad_ = 1.2, tipped_after_s_ = 0.1;
  double tipped_s_ = 0;
  bool tipped_ = false;
};

}  // namespace sinew::control
