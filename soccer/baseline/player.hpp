#pragma once
#include "msg/behaviour.hpp"
#include "msg/motion.hpp"
#include "msg/safety.hpp"
#include "rt/module.hpp"
#include "soccer/baseline/player_tree.hpp"

namespace sinew::soccer::baseline {

/// Plays soccer as if alone: goes to the ball and kicks it at the other goal. No roles, no radio. It is what teams are
/// judged by, so it does not change: docs/decisions/0040-the-baseline-is-a-copy.md.
/// Frames:  in: "field" and "robot"; out: speeds in the robot's own axes.
/// Thread:  executor; 10 Hz and more.   RT: yes.
/// Errors:  stale while nothing is known of the gait for 500 ms: nothing is published, and the walk stands.
class PlayBaseline final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  hal::Status configure(rt::Setup& setup) override;
  void reset() override;
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  void read_world(rt::Time now);
  void follow_request(const msg::GaitState& gait);

  const Field field_;
  PlayOptions options_;
  behaviour::Tree<PlayBoard> tree_;
  std::int64_t force_ = 0, player_ = 2;
  double kick_x_m_ = 0.15, kick_y_m_ = 0.05, step_kick_x_m_ = 0.19, step_kick_y_m_ = 0.05, out_x_m_ = 0, out_y_m_ = 0.2;

  rt::In<msg::FieldPose> pose_;
  rt::In<msg::BallModel> ball_;
  rt::In<msg::ObstacleModel> obstacles_;
  rt::In<msg::GaitState> gait_;
  rt::In<msg::RefereeState> referee_;
  rt::In<msg::SafetyState> safety_;
  rt::Out<msg::VelocityCommand> velocity_;
  rt::Out<msg::KickRequest> kick_;
  rt::Out<msg::GazeCommand> gaze_;
  rt::Out<msg::BehaviourState> state_;
  rt::Out<msg::BehaviourPlan> plan_;

  PlayBoard board_;

  // State:
  behaviour::Progress progress_;
  ChosenKick chosen_;
  FieldPoint ball_before_{0, 0};
  std::uint32_t asked_ = 0;
};

}  // namespace sinew::soccer::baseline
