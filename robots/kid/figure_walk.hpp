#pragma once
#include "msg/flight.hpp"
#include "msg/gait.hpp"
#include "msg/gaze.hpp"
#include "msg/motion.hpp"
#include "msg/referee.hpp"
#include "msg/safety.hpp"
#include "rt/module.hpp"

namespace sinew::kid {

/// Walks a figure by itself: stands, goes forward, to both sides and backward, a circle each way, and stands again.
/// It looks straight ahead, or at a ball whose place is known, except in the circles; or from side to side all the
/// time. Thread:  executor, 10 Hz or more.   RT: yes. Errors:  stale without a fresh gait: nothing is published, and
/// the walk stands.
///          A failsafe that asks to land ends the figure.
/// With `heed_referee` it walks only while the referee says that the game is on and that it may play, and stands
/// otherwise, also when nothing was heard of the referee for 3 s.
class FigureWalk final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  void reset() override;
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  void enter(msg::MissionPhase phase, rt::Time now);
  bool may_walk(rt::Time now) const;

  rt::In<msg::GaitState> gait_;
  rt::In<msg::SafetyState> safety_;
  rt::In<msg::RefereeState> referee_;
  rt::Out<msg::VelocityCommand> velocity_;
  rt::Out<msg::MissionState> mission_;
  rt::Out<msg::GazeCommand> gaze_;
  double stand_s_ = 2, forward_mps_ = 0.2, side_mps_ = 0.12, back_mps_ = 0.12, turn_radps_ = 0.5, leg_s_ = 5;
  bool heed_referee_ = false;
  bool looks_at_ball_ = false;
  double look_around_s_ = 0, look_around_rad_ = 1.1, look_down_rad_ = 0.35;
  double ball_x_m_ = 1, ball_y_m_ = 0, ball_z_m_ = 0.07;

  double in_phase_s_ = 0, look_s_ = 0;
  rt::Time since_{};
  msg::MissionPhase phase_ = msg::MissionPhase::wait;
  std::uint32_t leg_ = 0;  // of the figure
};

}  // namespace sinew::kid
