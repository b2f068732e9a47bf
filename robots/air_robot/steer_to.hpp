#pragma once
#include "msg/actuators.hpp"
#include "msg/flight.hpp"
#include "msg/head.hpp"
#include "msg/motion.hpp"
#include "robots/air_robot/steer_to_law.hpp"
#include "rt/module.hpp"

namespace sinew::air_robot {

/// Takes off, waits until the head has found its target, flies until it is over it, and stays there. See SteerToLaw.
/// Thread:  executor, 20 to 500 Hz, after the head.   RT: yes.
/// Errors:  stale without a fresh state with height and attitude, or without a fresh head: nothing is published, and
///          the guardian acts when the lease of the last command runs out; fault when they are nonsense.
///          When a failsafe asks for a landing it lands where it is.
class SteerTo final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  void reset() override { law_.reset(); }
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  rt::In<msg::NavState> state_;
  rt::In<msg::HeadState> head_;
  rt::In<msg::SafetyState> safety_;
  rt::Out<msg::VelocityCommand> velocity_;
  rt::Out<msg::MissionState> mission_;
  SteerToLaw law_;
};

}  // namespace sinew::air_robot
