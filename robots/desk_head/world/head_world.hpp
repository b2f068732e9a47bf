#pragma once
#include <memory>

#include "robots/desk_head/devices.hpp"
#include "robots/desk_head/world/head_dynamics.hpp"
#include "sim_hil/worlds/joints.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

struct HeadOptions {
  std::uint64_t seed = 1;
  double rock_deg = 10;       // the platform rolls and pitches by up to this
  double ball_speed = 1;      // share of its usual speed; 0: it stays where it starts
  bool sensor_errors = true;  // false: sensors and encoders tell the truth
  bool pillar = true;         // a pillar can hide the ball
};

/// A two-joint head with a camera and an IMU on a desk, on a platform that rocks, and a ball that moves in front of it.
/// The joints are integrated here, on equations of our own: MuJoCo's kinematics of hinges call the C library's sin and
/// cos. MuJoCo only draws the room.
/// Thread:  owner.
class HeadWorld final : public LoneRobot, public PlantJoints {
 public:
  explicit HeadWorld(const HeadOptions& options);
  ~HeadWorld() override;
  static WorldInfo info();

  /// Commands: positions of pan and tilt in rad; none: both without torque.
  void advance(std::span<const RobotCommand> commands) override;
  const Due& due() const override;
  msg::Time now() const override;
  WorldTruth ground_truth() const override;
  Scene scene(std::size_t camera) const override;
  bool still() const override;
  void add_to(JsonObject& report) const override;
  Verdict verdict() const override;
  std::string outcome() const override;
  PlantJoints* joints() override { return this; }

  std::size_t count() const override { return kHeadJoints; }
  JointMotion motion(std::size_t joint) const override;
  JointLimits limits(std::size_t joint) const override;
  void drive(std::size_t joint, const JointDrive& drive) override;
  void release(std::size_t joint) override;

  math::Vec3 ball_m() const;
  math::Quat q_world_base() const;
  math::Quat q_world_head() const;
  CameraPose camera_pose() const;
  /// True when the pillar hides some of the ball.
  bool ball_hidden() const;
  /// Angular rate and specific force at the IMU in the last step, without errors; head frame.
  LinkMotion imu_motion() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sinew::plant
