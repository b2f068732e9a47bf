#pragma once
#include "control/rotor_allocation.hpp"
#include "msg/actuators.hpp"
#include "msg/flight.hpp"
#include "rt/module.hpp"

namespace sinew::control {

/// Distributes torque and thrust to the four rotors. See RotorAllocation for their order and what gives way first.
/// Units:   commands are fractions of a rotor's full thrust, 0..1; all 0 while not armed.
/// Thread:  executor, right after the attitude controller.   RT: yes.
/// Errors:  stale without a fresh wrench; fault when it is not finite. Nothing is published then.
class Mixer final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  rt::In<msg::WrenchSetpoint> wrench_;
  rt::Out<msg::ActuatorCommand> motors_;
  RotorParams rotors_;
};

}  // namespace sinew::control
