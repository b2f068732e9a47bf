#pragma once
#include <optional>

#include "kinematics/limbs.hpp"
#include "motion/camera_pose.hpp"
#include "msg/camera_pose.hpp"
#include "msg/gait.hpp"
#include "msg/image.hpp"
#include "msg/joints.hpp"
#include "robots/robot_kind.hpp"
#include "rt/module.hpp"

namespace sinew::kid {

/// Says for each picture where its camera was at the middle of the exposure: the torso's place by
/// `gait` and the chain of the neck at the measurements before and after that instant, and the line between them. A
/// picture waits for the measurement after it, 20 ms or less; the next one takes the place of one that still waits.
/// Only of a body on its feet: of one that lies nothing is known to be on the ground. Thread:  executor, released by
/// `gait`.   RT: yes. Errors:  configure: bad_argument without a body, or without a place of the name `place`.
///          step: stale while a picture waits for measurements longer than 100 ms, and for one that is older than all
///          that are kept (256 ms at 125 Hz): nothing is said of it.
class CameraPose final : public rt::Module {
 public:
  explicit CameraPose(robots::RobotBody robot = {}) : robot_(std::move(robot)) {}
  void declare(rt::Declaration& d) override;
  hal::Status configure(rt::Setup& setup) override;
  void reset() override;
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  const robots::RobotBody robot_;
  std::string place_ = "camera";
  kinematics::Limbs limbs_;
  std::optional<kinematics::BodyPose> pose_;
  const kinematics::Place* camera_ = nullptr;

  rt::In<msg::Image> image_;
  rt::In<msg::GaitState> gait_;
  rt::In<msg::JointState> joints_;  // of the head
  rt::Out<msg::CameraPose> out_;

  std::vector<double> rad_;  // of all joints; only those of the head are used

  // State:
  motion::CameraHistory history_;
  rt::Time seen_{};   // the newest picture
  rt::Time waits_{};  // the same, until it was answered
};

}  // namespace sinew::kid
