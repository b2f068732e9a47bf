#pragma once
#include "control/attitude_law.hpp"
#include "rt/module.hpp"

namespace sinew::control {

/// Turns attitude and thrust into torque and thrust, through the rates of the body. See AttitudeLaw.
/// Thread:  executor, at the rate of the state (500 to 1000 Hz).   RT: yes.
/// Errors:  stale without a fresh state or setpoint; fault when what it got is not finite. Nothing is published then,
///          and the guardian acts when the lease of the last command runs out.
class AttitudeController final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  void reset() override { law_.reset(); }
  rt::Status step(const rt::Step& step) noexcept override;

 private:
  rt::In<msg::NavState> state_;
  rt::In<msg::AttitudeSetpoint> attitude_;
  rt::Out<msg::WrenchSetpoint> wrench_;
  AttitudeLaw law_;
};

}  // namespace sinew::control
