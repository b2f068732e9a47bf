#pragma once
#include "msg/flight.hpp"
#include "msg/gait.hpp"
#include "msg/gaze.hpp"
#include "msg/motion.hpp"
#include "msg/safety.hpp"
#include "rt/module.hpp"

namespace sinew::kid {

/// Kicks a ball that lies before a foot, or stops one that comes: stands or walks until it is time, asks for one
/// motion, and stands. It looks down at the ball before its feet until then.
/// Thread:  executor, 10 Hz or more.   RT: yes.
/// Errors:  stale without a fresh gait: nothing is published, and the walk stands.
///          A request that was refused or broken off, and a failsafe before it was done, abort the mission; 8 s later
///          it ends.
class KickPlan final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  void reset() override;
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  void enter(msg::MissionPhase phase, rt::Time now);

  rt::In<msg::GaitState> gait_;
  rt::In<msg::SafetyState> safety_;
  rt::Out<msg::VelocityCommand> velocity_;
  rt::Out<msg::KickRequest> kick_;
  rt::Out<msg::GazeCommand> gaze_;
  rt::Out<msg::MissionState> mission_;
  std::int64_t motion_ = 0, foot_ = 0;
  bool in_walk_ = false;
  double at_s_ = 3, forward_mps_ = 0, after_s_ = 1.5;

  double in_phase_s_ = 0;
  rt::Time since_{};
  msg::MissionPhase phase_ = msg::MissionPhase::wait;
  std::uint32_t asked_ = 0;
};

}  // namespace sinew::kid
