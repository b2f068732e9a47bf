#pragma once
#include <memory>
#include <vector>

#include "robots/gripper/world/gripper_world.hpp"
#include "robots/mixed/devices.hpp"
#include "sim_hil/pitch/pitch.hpp"
#include "sim_hil/pitch/pitch_robot.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

class MixedRobot;

/// Humanoids and wheeled robots with grippers on one pitch, with a wall, an orange ball behind it, and a goal to bring
/// it to. The verdict is the team's: every robot has the same one.
/// Thread:  owner.
class MixedWorld final : public World {
 public:
  /// Errors: bad_argument: a humanoid without a body, two robots in one place.
  static hal::Result<std::unique_ptr<MixedWorld>> create(const WorldChoice& choice, std::uint64_t seed);
  ~MixedWorld() override;

  void advance(std::span<const RobotCommand> commands) override;
  msg::Time now() const override { return {steps_ * kStepNs}; }
  std::size_t robots() const override;
  SimRobot& robot(std::size_t number) override;
  const Pitch& pitch() const { return *pitch_; }

  /// The object was carried, lies at the goal at rest, and nobody is at it any more.
  Verdict verdict() const;
  void add_to(JsonObject& report) const;

 private:
  MixedWorld(std::unique_ptr<Pitch> pitch, const WorldChoice& choice, std::uint64_t seed);
  double error_m() const;
  bool any_holds() const;
  const GripperOnPitch* carrier() const;

  std::unique_ptr<Pitch> pitch_;
  std::vector<std::unique_ptr<MixedRobot>> robots_;
  std::vector<const GripperOnPitch*> grippers_;  // null: a humanoid
  math::Vec3 goal_m_;
  std::int64_t steps_ = 0;
  double gripped_s_ = -1, brought_s_ = -1;  // first; -1: not yet
};

/// What its pitch is made of. `seed`: of where the object lies.
PitchOptions mixed_pitch(const WorldChoice& choice, std::uint64_t seed);
std::vector<PitchBody> mixed_bodies(const WorldChoice& choice);

}  // namespace sinew::plant
