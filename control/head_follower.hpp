#pragma once
#include "control/head_law.hpp"
#include "msg/actuators.hpp"
#include "rt/module.hpp"

namespace sinew::control {

/// Turns a two-joint head so that its camera stays level and follows a ball. See HeadLaw. With `safety` bound it arms
/// only when the guardian permits it. It gives its joints up when a failsafe stops them, and looks straight ahead,
/// level, when a failsafe asks to land. For a head that stands on a desk, and for one below a vehicle (`imu_on_base`).
/// Units:   commands are positions in rad: pan, tilt.
/// Thread:  executor, 100 to 1000 Hz, after the estimate.   RT: yes.
/// Errors:  stale without a fresh and valid attitude, without fresh joints, or while a joint's position is still no
///          number; fault when the joints' values are impossible for a head. Nothing is published then, and the
///          guardian acts when the last command's lease runs out.
class HeadFollower final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  void reset() override { law_.reset(); }
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  rt::In<msg::NavState> state_;
  rt::In<msg::JointState> joints_;
  rt::InQueue<msg::BallSighting> ball_;
  rt::In<msg::SafetyState> safety_;
  rt::Out<msg::ActuatorCommand> command_;
  rt::Out<msg::HeadState> head_;
  HeadLaw law_;
  bool imu_on_base_ = false, ball_below_ = false;
  double state_age_s_ = 0.02, joints_age_s_ = 0.02;
};

}  // namespace sinew::control
