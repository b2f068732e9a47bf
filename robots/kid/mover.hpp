#pragma once
#include <memory>
#include <vector>

#include "kinematics/limbs.hpp"
#include "motion/ball_stop.hpp"
#include "motion/fall.hpp"
#include "motion/kick.hpp"
#include "motion/motion_book.hpp"
#include "motion/pose_motions.hpp"
#include "motion/walk.hpp"
#include "msg/actuators.hpp"
#include "msg/gait.hpp"
#include "msg/joints.hpp"
#include "msg/kick.hpp"
#include "msg/motion.hpp"
#include "msg/safety.hpp"
#include "msg/sensors.hpp"
#include "robots/robot_kind.hpp"
#include "rt/module.hpp"

namespace sinew::kid {

/// Stands, walks where it is told to, gives way when it falls, and rises again where the motion file says how
/// (motion/pose_motions.hpp): from what the body measures to angles of all joints (docs/walking.md). Without
/// `velocity`, or without a fresh one, it stands. With `safety` bound it moves only when the guardian permits it; a
/// failsafe that asks to land makes it stop, stand, and get down ("get_down") to where it needs no torque. A
/// KickRequest makes it kick, within a step or from a stand, or stop a ball that rolls towards it; it takes one at a
/// time, and `gait` says what becomes of it. What the motion file does not have is left out.
/// Units:   commands are angles in rad, limb by limb (kinematics::Limbs).
/// Thread:  executor, 100 Hz or more, after its sensors.   RT: yes.
/// Errors:  configure: bad_argument without a body, or with one that has no two legs as Figure::make() wants them.
///          While IMU or soles are lost the attitude and the odometry of `gait` stay what they were.
///          step: stale without fresh joints of both legs (without get_down: or IMU or soles): nothing is published
///          then, and the guardian acts when the leases run out. fault when joints are no angles.
class Mover final : public rt::Module {
 public:
  explicit Mover(robots::RobotBody robot = {});
  void declare(rt::Declaration& d) override;
  hal::Status configure(rt::Setup& setup) override;
  void reset() override;
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  /// The motions' states, to numbers and from those of the step before.
  void write_motions(std::span<double> out) noexcept;
  void read_motions() noexcept;
  bool sense_joints(rt::Time now) noexcept;
  bool sense_balance(rt::Time now) noexcept;
  void move(const rt::Step& step) noexcept;
  void get_up(const rt::Step& step) noexcept;
  void get_down(const rt::Step& step) noexcept;
  /// False: the motion file has no such motion.
  bool play(motion::PoseMotion motion) noexcept;
  void enter(msg::GaitMode mode, rt::Time now) noexcept;
  // What is asked for at a ball:
  void take_requests() noexcept;
  msg::RequestRefusal refusal_of(const msg::KickRequest& request) const noexcept;
  bool is_open() const noexcept;        // a request is
  bool stands_for_it() const noexcept;  // the request that is open is not for a step of the walk
  bool failsafe_acts() const noexcept;
  void begin_request(const rt::Step& step) noexcept;
  void move_at_ball(const rt::Step& step) noexcept;
  void follow_request() noexcept;
  bool asks_to_land() const noexcept;
  motion::WalkCommand command(rt::Time now) const noexcept;
  void publish() noexcept;

  const robots::RobotBody robot_;
  kinematics::Limbs limbs_;
  std::optional<motion::Figure> figure_;
  std::unique_ptr<motion::Walk> walk_;
  std::unique_ptr<motion::Kick> kick_;
  std::unique_ptr<motion::BallStop> stop_;
  motion::FallDetector fall_;
  motion::PosePlayer poses_;
  std::optional<motion::PoseMotions> pose_motions_;  // none before configure()
  motion::WalkParams walk_params_;
  motion::FallParams fall_params_;
  motion::KickParams kick_forward_, kick_outward_;
  motion::StepKickParams step_kick_forward_, step_kick_outward_;
  motion::BallStopParams stop_params_;

  rt::In<msg::ImuSample> imu_;
  rt::In<msg::SolePressure> soles_;
  std::array<rt::In<msg::JointState>, kinematics::kLimbs> joints_;
  rt::In<msg::VelocityCommand> velocity_;
  rt::InQueue<msg::KickRequest> requests_;
  rt::In<msg::SafetyState> safety_;
  std::array<rt::Out<msg::ActuatorCommand>, kinematics::kLimbs> limb_;
  rt::Out<msg::GaitState> gait_;

  math::Quat q_torso_imu_;
  std::vector<double> at_begin_;  // `kept_` of motions that have not moved yet

  // Of one step:
  motion::Sensed sensed_;
  rt::Time measured_{};

  // State:
  std::vector<double> rad_;      // measured, in the body's order
  std::vector<double> targets_;  // NaN: no torque
  std::vector<double> kept_;     // of the motions
  rt::Time since_{};
  msg::GaitMode mode_ = msg::GaitMode::limp;
  std::uint32_t falls_ = 0;
  motion::PoseMotion plays_ = motion::PoseMotion::none;  // or played last
  double height_m_ = 0;
  msg::KickRequest request_;  // taken last
  msg::RequestProgress progress_ = msg::RequestProgress::none;
  std::uint32_t refused_ = 0;
  msg::RequestRefusal refusal_ = msg::RequestRefusal::none;
};

}  // namespace sinew::kid
