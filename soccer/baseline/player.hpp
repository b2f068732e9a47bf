#pragma once
#include "msg/gait.hpp"
#include "msg/gaze.hpp"
#include "msg/kick.hpp"
#include "msg/motion.hpp"
#include "msg/referee.hpp"
#include "msg/safety.hpp"
#include "rt/module.hpp"
#include "soccer/world/field_at.hpp"

namespace sinew::soccer {

/// What teams are judged by (docs/decisions/0040-the-baseline-is-frozen-and-small.md): goes behind the ball and kicks
/// it at the other goal, by what the robot itself sees. No role, no mates. It does not change when soccer/play does.
/// Frames:  in: "field" and "robot"; out: speeds in the robot's own axes.
/// Thread:  executor; 10 Hz and more.   RT: yes.
/// Errors:  stale while nothing is known of the gait for 500 ms: nothing is published, and the walk stands.
class PlayBaseline final : public rt::Module {
 public:
  enum class Doing : std::uint32_t { stand, search, approach, align, kick, follow };

  void declare(rt::Declaration& d) override;
  void reset() override;
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  /// What it believes in this step. Frame "robot" where nothing else is said.
  struct Seen {
    FieldAt self{};  // frame "field"
    FieldPoint ball{0, 0};
    bool found = false, sees_ball = false, has_nearest = false;
    FieldPoint nearest{0, 0};  // of the other robots: its middle
    double nearest_radius_m = 0;
  };
  struct Speed {
    double forward_mps = 0, left_mps = 0, turn_radps = 0;
  };
  Seen look_around(rt::Time now) const;
  /// Where to be in this phase of the game before play, or nowhere: frame "field".
  FieldAt ready_place(bool own_kick_off) const;
  FieldAt place_for_kick(const Seen& seen, double behind_m) const;
  Speed go_to(const FieldAt& place, const Seen& seen, bool round_ball) const;
  /// One step of the states; false: it must not play now.
  Speed play(const Seen& seen, const msg::GaitState& gait, rt::Time now);
  void become(Doing next, rt::Time now);
  bool others_kick(const Seen& seen, const msg::RefereeState* said) const;

  const Field field_;
  std::int64_t player_ = 2;
  double kick_x_m_ = 0.19, kick_y_m_ = 0.05;

  rt::In<msg::FieldPose> pose_;
  rt::In<msg::BallModel> ball_;
  rt::In<msg::ObstacleModel> obstacles_;
  rt::In<msg::GaitState> gait_;
  rt::In<msg::RefereeState> referee_;
  rt::In<msg::SafetyState> safety_;
  rt::Out<msg::VelocityCommand> velocity_;
  rt::Out<msg::KickRequest> kick_;
  rt::Out<msg::GazeCommand> gaze_;

  // State:
  Doing doing_ = Doing::stand;
  rt::Time since_{};
  msg::Foot foot_ = msg::Foot::left;
  FieldPoint ball_at_set_{0, 0};  // frame "field"
  std::uint32_t asked_ = 0;       // kicks
};

}  // namespace sinew::soccer
