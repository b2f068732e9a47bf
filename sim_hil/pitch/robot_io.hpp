#pragma once
// What lies between a robot's computer and its body: delays, noise, offsets.
#include <array>
#include <vector>

#include "math/random.hpp"
#include "sim_hil/pitch/pitch.hpp"

namespace sinew::plant {

/// Numbers of one robot that the seed draws once.
struct RobotDraw {
  std::int64_t command_delay_ns = 0;
  double sole_friction = 0.8;
  std::array<double, kMostJoints> gain{};  // factors
  std::array<double, kinematics::kMaxLinks> mass{};
  math::Vec3 gyro_bias_radps, accel_bias_mps2;
  std::array<std::array<double, 4>, 2> cell{};
  std::array<double, kMostJoints> zero_rad{};
  std::array<kinematics::Pose, 2> sole{};  // left, right: the true one in the frame of the drawing's

  RobotDraw(const BodyErrors& errors, std::uint64_t seed, std::size_t robot);
};

/// Thread:  owner.   RT: yes.
class RobotIo {
 public:
  RobotIo(const BodyErrors& errors, const RobotDraw& draw, std::size_t joints, std::uint64_t seed, std::size_t robot);

  std::size_t joints() const { return joints_; }
  /// What the robot's computer said last.
  JointDrive& said(std::size_t joint) { return said_[joint]; }
  /// Once a step, before it: what the servos obey in it.
  std::span<const JointDrive> obeyed();
  /// Once a step, after it: true values at `now`, to which noise and offsets are added. Updates sensors().
  struct Measured {
    std::array<JointReading, kMostJoints> joint{};
    math::Vec3 gyro_radps, accel_mps2;
    std::array<std::array<double, 4>, 2> cell_n{};
  };
  void measure(const Measured& value, std::int64_t now_ns);
  const BodySensors& sensors() const { return sensors_; }

 private:
  static constexpr std::size_t kRing = 32;  // steps: delays are at most 62 ms
  struct Imu {
    math::Vec3 gyro_radps, accel_mps2;
    std::int64_t stamp_ns = 0;
  };
  struct Slow {
    std::array<JointReading, kMostJoints> joint{};
    std::array<std::array<double, 4>, 2> cell_n{};
    std::int64_t stamp_ns = 0;
  };

  BodyErrors errors_;
  RobotDraw draw_;
  std::size_t joints_;
  math::Random noise_;
  std::size_t command_steps_, joint_steps_, imu_steps_;
  std::size_t steps_ = 0, samples_ = 0;
  std::array<JointDrive, kMostJoints> said_{}, obeyed_{};
  std::vector<std::array<JointDrive, kMostJoints>> on_the_way_;
  std::vector<Imu> imu_;
  std::vector<Slow> slow_;
  BodySensors sensors_;
};

}  // namespace sinew::plant
