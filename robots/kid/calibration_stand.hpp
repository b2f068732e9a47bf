#pragma once
#include <optional>
#include <vector>

#include "kinematics/limbs.hpp"
#include "motion/sole_level.hpp"
#include "motion/stand_poses.hpp"
#include "msg/actuators.hpp"
#include "msg/flight.hpp"
#include "msg/joints.hpp"
#include "msg/sensors.hpp"
#include "robots/robot_kind.hpp"
#include "rt/module.hpp"

namespace sinew::kid {

/// Stands on both feet before a printed chessboard on the ground and goes from pose to pose, still for a while in each:
/// the motion of which a recording is calibrated (docs/calibrate.md). It takes the place of the mover and of the gaze.
/// Every pose has its centre of mass between the feet; with `soles` bound, the ankles give way until both soles are
/// pressed evenly (motion::SoleLevel), whatever the joints' zeros are.
/// Units:   commands are angles in rad, limb by limb (kinematics::Limbs).
/// Thread:  executor, 50 Hz or more.   RT: yes.
/// Errors:  configure: bad_argument without a body, with one that has no two legs, or with one that reaches fewer than
///          half of the poses. step: stale until both legs were measured; nothing is published then.
class CalibrationStand final : public rt::Module {
 public:
  explicit CalibrationStand(robots::RobotBody robot = {}) : robot_(std::move(robot)) {}
  void declare(rt::Declaration& d) override;
  hal::Status configure(rt::Setup& setup) override;
  void reset() override;
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  const robots::RobotBody robot_;
  motion::StandPosesOptions options_;
  std::int64_t poses_ = 40, seed_ = 1;
  double move_s_ = 0.6, hold_s_ = 0.9;
  kinematics::Limbs limbs_;
  std::optional<motion::Figure> figure_;
  std::optional<motion::SoleLevel> level_;
  std::vector<motion::JointAngles> pose_;
  std::vector<double> rad_;  // of a step

  std::array<rt::In<msg::JointState>, kinematics::kLimbs> joints_;
  rt::In<msg::SolePressure> soles_;
  std::array<rt::Out<msg::ActuatorCommand>, kinematics::kLimbs> limb_;
  rt::Out<msg::MissionState> mission_;

  // State:
  std::vector<double> from_;  // where the way to the first pose begins
  std::array<double, 4> turn_rad_{};
  rt::Time begin_{};  // of the way to the first pose; 0: not yet
};

}  // namespace sinew::kid
