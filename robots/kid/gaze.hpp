#pragma once
#include <optional>
#include <vector>

#include "kinematics/limbs.hpp"
#include "motion/motion_book.hpp"
#include "msg/actuators.hpp"
#include "msg/gait.hpp"
#include "msg/gaze.hpp"
#include "msg/joints.hpp"
#include "robots/robot_kind.hpp"
#include "rt/module.hpp"

namespace sinew::kid {

/// Turns the head to where it is told to look, the motion of the body below it taken out (motion::Gaze). It stands
/// between the mover's angles of the head and the head's actuators: while the robot is not on its feet, and without a
/// command, with GazeAim::rest or with a command that makes no sense, these angles go through as they are.
/// Units:   commands are angles in rad, in the order of the limb `head` (kinematics::Limbs).
/// Thread:  executor, after the mover and in its thread.   RT: yes.
/// Errors:  configure: bad_argument without a body, or with one that has no two legs as Figure::make() wants them.
///          step: stale without a fresh gait, fresh angles of the mover and fresh joints of the head: nothing is
///          published, and the guardian acts when the lease of the head runs out. fault when joints are no angles.
class Gaze final : public rt::Module {
 public:
  explicit Gaze(robots::RobotBody robot = {});
  void declare(rt::Declaration& d) override;
  hal::Status configure(rt::Setup& setup) override;
  void reset() override;
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  /// False: the command is to rest, or makes no sense.
  bool aim(const msg::GazeCommand& command, const msg::GaitState& gait) noexcept;

  const robots::RobotBody robot_;
  kinematics::Limbs limbs_;
  std::optional<motion::Figure> figure_;
  std::optional<motion::Gaze> law_;
  motion::GazeParams params_;

  rt::In<msg::GaitState> gait_;
  rt::In<msg::ActuatorCommand> motions_;
  rt::In<msg::JointState> joints_;
  rt::In<msg::GazeCommand> command_;
  rt::Out<msg::ActuatorCommand> head_;
  rt::Out<msg::GazeState> state_;

  std::vector<double> at_begin_;  // `kept_` of a law that has not looked yet

  // Of one step:
  std::vector<double> rad_, targets_;  // of all joints; only those of the head are used

  // State:
  std::vector<double> kept_;  // of the law
};

}  // namespace sinew::kid
