#pragma once
#include <memory>

#include "robots/gripper/devices.hpp"
#include "robots/gripper/world/carry_score.hpp"
#include "sim_hil/pitch/pitch.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

/// A wheeled robot with a gripper on the pitch (sim_hil/pitch/wheeled.hpp), and an orange ball.
/// Thread:  owner.
class GripperWorld final : public LoneRobot, public PlantJoints {
 public:
  static WorldInfo info();
  static hal::Result<std::unique_ptr<GripperWorld>> create(const WorldChoice& choice, std::uint64_t seed);

  void advance(std::span<const RobotCommand> commands) override;
  msg::Time now() const override { return {steps_ * kStepNs}; }
  const Pitch& pitch() const { return *pitch_; }

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
  GripperWorld(std::unique_ptr<Pitch> pitch, const PitchPlace& start);
  void act(RobotCommand given);
  void command(std::size_t joint, const JointDrive& drive);
  bool drives(std::size_t joint) const;
  void sample();

  std::unique_ptr<Pitch> pitch_;
  CarryScore score_;
  std::array<double, kJoints> commanded_{};
  std::array<std::optional<JointDrive>, kJoints> taken_{};  // by drives at the wire
  bool released_ = true;                                    // the commands have to go out again
  std::int64_t steps_ = 0;
  Due due_;
};

/// What it is made of.
PitchOptions gripper_pitch(const WorldInfo& info, const WorldValues& values, std::uint64_t seed);
PitchBody gripper_body(const WorldInfo& info, const WorldValues& values);

}  // namespace sinew::plant
