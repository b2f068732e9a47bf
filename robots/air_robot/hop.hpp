#pragma once
#include "msg/actuators.hpp"
#include "msg/flight.hpp"
#include "msg/motion.hpp"
#include "msg/safety.hpp"
#include "rt/module.hpp"

namespace sinew::air_robot {

/// Takes off, hovers, flies forward, hovers, lands: for robots that are steered by velocities. The height is held by
/// the vertical velocity, in the units of the state. Takes off by the command `fly` (1 in the air, 0 on the ground) if
/// its command group is in the robot file; without one by climbing. Thread:  executor.   RT: yes. Errors:  stale
/// without a fresh state: nothing is published, and the guardian acts when the lease of the last command
///          runs out. When a failsafe asks for a landing it lands where it is.
class Hop final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  void reset() override { phase_ = msg::MissionPhase::wait, in_phase_s_ = 0; }
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  void enter(msg::MissionPhase phase, rt::Time now);
  void plan(const msg::NavState& state, rt::Time now);
  bool flying() const;

  rt::In<msg::NavState> state_;
  rt::In<msg::SafetyState> safety_;
  rt::Out<msg::VelocityCommand> velocity_;
  rt::Out<msg::ActuatorCommand> fly_;
  rt::Out<msg::MissionState> mission_;
  double height_m_ = 1.2, forward_mps_ = 0.5, forward_s_ = 3, hover_s_ = 2, climb_mps_ = 0.4, gain_ = 1;
  double landed_m_ = 0.15, limit_s_ = 30;
  bool on_ground_ = false;  // drives on the ground: no height

  msg::MissionPhase phase_ = msg::MissionPhase::wait;
  double in_phase_s_ = 0;
  rt::Time since_{};
};

}  // namespace sinew::air_robot
