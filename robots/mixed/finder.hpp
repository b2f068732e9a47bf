#pragma once
#include "msg/flight.hpp"
#include "msg/gait.hpp"
#include "msg/gaze.hpp"
#include "msg/motion.hpp"
#include "msg/safety.hpp"
#include "msg/soccer.hpp"
#include "rt/module.hpp"

namespace sinew::mixed {

/// A humanoid that finds an object for others: it looks from side to side, turns where it sees nothing, and keeps its
/// eyes on what it has found until the team has brought it to the goal.
/// Frames:  ball: "robot"; team and goal: "field" of msg/soccer.hpp.
/// Thread:  executor, 10 Hz or more.   RT: yes.
/// Errors:  stale without a fresh gait: nothing is published, and the walk stands. A failsafe that asks to land ends
/// it.
class Finder final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  void reset() override;
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  void enter(msg::MissionPhase phase, rt::Time now);
  bool is_brought(rt::Time now);

  rt::In<msg::GaitState> gait_;
  rt::In<msg::BallModel> ball_;
  rt::In<msg::TeamModel> team_;
  rt::In<msg::SafetyState> safety_;
  rt::Out<msg::VelocityCommand> velocity_;
  rt::Out<msg::GazeCommand> gaze_;
  rt::Out<msg::MissionState> mission_;
  double goal_x_m_ = -3.5, goal_y_m_ = 0, goal_within_m_ = 0.8;
  double look_s_ = 4, look_rad_ = 1.1, down_rad_ = 0.35, turn_radps_ = 0.5, stand_s_ = 2, least_confidence_ = 0.4;

  // Saved with a recording.
  double in_phase_s_ = 0, look_now_s_ = 0, brought_s_ = 0;
  rt::Time since_{};
  msg::MissionPhase phase_ = msg::MissionPhase::wait;
};

}  // namespace sinew::mixed
