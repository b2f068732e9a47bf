#pragma once
#include <memory>

#include "robots/gripper/devices.hpp"
#include "robots/gripper/world/carry_score.hpp"
#include "sim_hil/pitch/pitch.hpp"
#include "sim_hil/pitch/pitch_robot.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

/// A wheeled robot with a gripper on a pitch (sim_hil/pitch/wheeled.hpp), as its session sees it.
/// Thread:  the world's.
class GripperOnPitch final : public PitchRobot, public PlantJoints {
 public:
  /// The pitch has its body as this number. `goal_m`: where the ball is to be brought.
  GripperOnPitch(Pitch& pitch, std::size_t number, const math::Vec3& goal_m);

  const CarryScore& score() const { return score_; }

  // ---- PitchRobot
  void act(RobotCommand given, std::int64_t now_ns) override;
  void sample(std::int64_t steps) override;
  void nothing_due() override;

  // ---- SimRobot
  const Due& due() const override { return due_; }
  WorldTruth ground_truth() const override;
  Scene scene(std::size_t camera) const override;
  bool still() const override;
  std::uint32_t news() const override { return score_.grips() + (score_.has_begun() ? 1 : 0); }
  void add_to(JsonObject& report) const override;
  Verdict verdict() const override { return score_.verdict(); }
  std::string outcome() const override { return score_.text(); }
  PlantJoints* joints() override { return this; }

  // ---- PlantJoints: both wheels, then the gripper's motor
  std::size_t count() const override { return kJoints; }
  JointMotion motion(std::size_t joint) const override;
  JointLimits limits(std::size_t joint) const override;
  void drive(std::size_t joint, const JointDrive& drive) override;
  void release(std::size_t joint) override;

 private:
  static constexpr std::size_t kJoints = 3, kGripperJoint = 2;
  void command(std::size_t joint, const JointDrive& drive);
  bool drives(std::size_t joint) const;

  Pitch& pitch_;
  const std::size_t number_;
  CarryScore score_;
  std::array<double, kJoints> commanded_{};
  std::array<std::optional<JointDrive>, kJoints> taken_{};  // by drives at the wire
  bool released_ = true;                                    // the commands have to go out again
  Due due_;
};

/// That robot alone on the pitch, and an orange ball.
/// Thread:  owner.
class GripperWorld final : public World {
 public:
  static WorldInfo info();
  static hal::Result<std::unique_ptr<GripperWorld>> create(const WorldChoice& choice, std::uint64_t seed);

  void advance(std::span<const RobotCommand> commands) override;
  msg::Time now() const override { return {steps_ * kStepNs}; }
  std::size_t robots() const override { return 1; }
  SimRobot& robot(std::size_t /*number*/) override { return robot_; }
  const Pitch& pitch() const { return *pitch_; }

 private:
  GripperWorld(std::unique_ptr<Pitch> pitch, const PitchPlace& start);

  std::unique_ptr<Pitch> pitch_;
  GripperOnPitch robot_;
  std::int64_t steps_ = 0;
};

/// What it is made of.
PitchOptions gripper_pitch(const WorldInfo& info, const WorldValues& values, std::uint64_t seed);
PitchBody gripper_body(const WorldInfo& info, const WorldValues& values);

}  // namespace sinew::plant
