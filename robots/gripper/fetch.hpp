#pragma once
#include "control/pose_history.hpp"
#include "msg/flight.hpp"
#include "msg/head.hpp"
#include "msg/joints.hpp"
#include "msg/motion.hpp"
#include "msg/safety.hpp"
#include "msg/soccer.hpp"
#include "robots/gripper/wall_way.hpp"
#include "rt/module.hpp"
#include "soccer/play/walk_to.hpp"

namespace sinew::gripper {

/// Fetches a ball: looks for it, drives to it, closes the gripper, brings the ball to where the robot began, opens the
/// gripper and backs off. A gripper that closed on nothing is opened, and the robot looks again.
/// With `for_team` it does so for a team: it fetches while the team needs it as the striker (soccer::Team), drives to
/// where the team had the ball last until it sees it by itself, round the wall and its mates, and brings it to the
/// goal. It stands while another one is the striker, and while it hears nobody. It ends when the ball lies at the goal.
/// Frames:  of the state: world where the robot began, x ahead. The camera is a place of the base. Ball out: "robot",
///          goal, wall and team: "field" of msg/soccer.hpp.
/// Thread:  executor, 20 Hz or more.   RT: yes.
/// Errors:  stale without a fresh state and a fresh gripper: nothing is published, and both groups fall back by their
///          leases. A failsafe that asks to land ends it: the robot stands, and holds what it holds.
class Fetch final : public rt::Module {
 public:
  void declare(rt::Declaration& d) override;
  void reset() override;
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  struct Point {
    double x_m = 0, y_m = 0;
  };
  struct Known {
    std::uint32_t start = 0, team_ball = 0;
  };
  struct Drive {
    double forward_mps = 0, turn_radps = 0;
  };
  void enter(msg::MissionPhase phase, rt::Time now);
  void see(const msg::BallSighting& ball);
  bool has_stalled(const msg::JointState& gripper) const;
  void hear(const msg::NavState& state, double dt_s, rt::Time now);
  bool may_fetch(rt::Time now) const;
  Point goal() const;
  void tell(const msg::NavState& state, rt::Time now);
  Drive drive_to(Point to, double stop_m, const msg::NavState& state);
  Drive act(const msg::NavState& state, const msg::JointState& gripper, rt::Time now);
  Drive look_for_ball(const msg::NavState& state, rt::Time now);
  Drive approach(const msg::NavState& state, rt::Time now);
  Drive close(const msg::JointState& gripper, rt::Time now);
  Drive bring(const msg::NavState& state, const msg::JointState& gripper, rt::Time now);
  Drive let_go(const msg::NavState& state, const msg::JointState& gripper, rt::Time now);

  rt::In<msg::NavState> state_;
  rt::In<msg::JointState> gripper_joint_;
  rt::In<msg::BallSighting> ball_;
  rt::In<msg::SafetyState> safety_;
  rt::In<msg::TeamModel> team_;
  rt::In<msg::FieldPose> field_;
  rt::Out<msg::BallModel> ball_model_;
  rt::Out<msg::VelocityCommand> velocity_;
  rt::Out<msg::ActuatorCommand> gripper_;
  rt::Out<msg::MissionState> mission_;
  double camera_x_m_ = 0.1, camera_z_m_ = 0.28, camera_down_rad_ = 0.3, ball_radius_m_ = 0.07;
  double grip_at_m_ = 0.26, closed_rad_ = 10.75, held_from_rad_ = 2.5, held_to_rad_ = 6;
  double fast_mps_ = 0.35, slow_mps_ = 0.12, carry_mps_ = 0.3, search_radps_ = 0.6;
  double wait_s_ = 2, home_within_m_ = 0.1;
  bool for_team_ = false;
  double goal_x_m_ = -3.5, goal_y_m_ = 0;
  Wall wall_;
  double mate_radius_m_ = 0.3, margin_m_ = 0.35, brought_within_m_ = 0.8;

  // Saved with a recording.
  control::PoseHistory past_;
  Point ball_at_{}, mark_{};  // mark: where it began to back off
  double in_phase_s_ = 0, stalled_s_ = 0, unseen_s_ = 0;
  double brought_s_ = 0, told_s_ = 0, looked_s_ = 0;
  soccer::FieldAt start_{};  // of its own frame on the field
  Point team_ball_{};        // own frame
  Known known_{};
  WallEnd wall_end_ = WallEnd::none;  // past which it goes now
  rt::Time since_{}, ball_stamp_{};
  msg::MissionPhase phase_ = msg::MissionPhase::wait;
  std::uint32_t sightings_ = 0;  // one after the other, near each other
  std::uint32_t closes_ = 0;     // 1: the gripper is told to be closed
  std::uint32_t backs_off_ = 0;  // 1: away from a ball that it missed

  // Of this step: mates that are in the way, in the robot's frame.
  std::array<soccer::Round, 7> round_{};
  std::size_t rounds_ = 0;
  double dt_s_ = 0;
};

}  // namespace sinew::gripper
