#pragma once
#include <optional>

#include "sim_hil/pitch/model.hpp"
#include "sim_hil/pitch/robot_io.hpp"
#include "sim_hil/pitch/servo.hpp"
#include "sim_hil/pitch/stance.hpp"

namespace sinew::plant {

/// A robot of a run: its true body, and what is between it and its computer.
struct PitchRobot {
  ModelRobot model;
  BodyErrors errors;
  RobotDraw draw;
  RobotIo io;
  std::array<std::optional<Sole>, 2> soles;
  std::vector<GearedServo> servo{};
  std::vector<double> limit{};  // by joint: the largest share of the voltage
  BodyTruth truth{};
  RobotIo::Measured measured{};
  math::Vec3 push_n{};
  std::int64_t push_end_ns = 0;
};

std::vector<PitchRobot> robots_of(std::span<const PitchBody> bodies, std::uint64_t seed);

/// What the pitch does in the same way whatever moves the bodies.
class PitchOfRobots : public Pitch {
 public:
  PitchOfRobots(const PitchOptions& options, std::vector<PitchRobot> robots) : o_(options), robot_(std::move(robots)) {}

  std::size_t robots() const final { return robot_.size(); }
  const kinematics::Body& body(std::size_t robot) const final { return robot_[robot].model.body; }
  std::int64_t now_ns() const final { return now_ns_; }
  const BodySensors& sensors(std::size_t robot) const final { return robot_[robot].io.sensors(); }
  const BodyTruth& truth(std::size_t robot) const final { return robot_[robot].truth; }
  const BallTruth& ball() const final { return ball_; }
  double joint_zero_rad(std::size_t robot, std::size_t joint) const final { return robot_[robot].draw.zero_rad[joint]; }
  std::int64_t command_delay_ns(std::size_t robot) const final { return robot_[robot].draw.command_delay_ns; }
  void command(std::size_t robot, std::span<const double> targets_rad) final;
  void command(std::size_t robot, std::size_t joint, const JointDrive& drive) final;
  void limit(std::size_t robot, std::size_t joint, double share) final;
  void gain(std::size_t robot, std::size_t joint, double gain_per_rad) final;
  void push(std::size_t robot, const math::Vec3& impulse_ns, std::int64_t duration_ns) final;

 protected:
  PitchOptions o_;
  std::vector<PitchRobot> robot_;
  std::int64_t now_ns_ = 0;
  BallTruth ball_;
};

}  // namespace sinew::plant
