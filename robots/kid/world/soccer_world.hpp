#pragma once
#include <memory>
#include <string>
#include <vector>

#include "robots/kid/devices.hpp"
#include "sim_hil/pitch/pitch.hpp"
#include "sim_hil/pitch/pitch_robot.hpp"
#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

/// One humanoid of the world "soccer".
struct SoccerRobot {
  PitchBody body;
  math::Vec3 push_ns;  // every 10 s from the third second on; in the world's axes
};

/// Humanoids on a soccer field, on MuJoCo's dynamics (sim_hil/pitch), as a robot's session sees them.
/// Thread:  owner.
class SoccerWorld final : public World {
 public:
  static WorldInfo info();
  /// The robots of a choice, as their values say. Errors: bad_argument, `why` has it: two in one place, no body.
  static hal::Result<std::unique_ptr<SoccerWorld>> create(const WorldChoice& choice, std::uint64_t seed);
  ~SoccerWorld() override;

  /// Commands: angles of the joints, limb after limb (kKidLimbJoints), rad; NaN: without torque.
  void advance(std::span<const RobotCommand> commands) override;
  msg::Time now() const override;
  std::size_t robots() const override;
  SimRobot& robot(std::size_t number) override;
  const Pitch& pitch() const;

 private:
  struct Impl;
  explicit SoccerWorld(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// What it is made of.
PitchOptions pitch_options_of(const WorldInfo& info, const WorldValues& values);
std::vector<SoccerRobot> soccer_robots_of(const WorldChoice& choice);
/// One of them. Options that the world does not have are 0, the place as by its number.
SoccerRobot soccer_robot_of(const WorldChoice& choice, std::size_t number);
/// One of them on a pitch of another world, that has its body as this number. No game.
std::unique_ptr<PitchRobot> kid_on_pitch(const SoccerRobot& robot, Pitch& pitch, std::size_t number,
                                         std::uint64_t seed);
/// Draws scenes of SoccerRobot::scene().
std::unique_ptr<Painter> soccer_painter(std::uint32_t width, std::uint32_t height, const WorldChoice& choice);

}  // namespace sinew::plant
