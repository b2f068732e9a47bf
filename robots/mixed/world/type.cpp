// The world "mixed", for the list of worlds.
#include "robots/mixed/world/mixed_world.hpp"
#include "sim_hil/pitch/painter.hpp"

namespace sinew::robots {

plant::WorldType describe_world_of_mixed();

}  // namespace sinew::robots

namespace sinew::plant {
namespace {

/// From outside, and through the first camera of each robot.
std::vector<Portrait> mixed_portraits(const WorldChoice& choice) {
  const auto world = choice.create(1);
  if (!world) return {};
  const std::vector<double> still(choice.type->info.channels(Part::actuators), 0);
  const std::vector<RobotCommand> all(choice.robot_count(), RobotCommand(still));
  for (int i = 0; i < 1200; ++i) (*world)->advance(all);
  std::vector<Portrait> portraits{
      {"mixed", (*world)->robot(0).scene(0), Viewpoint{{-3.2, -2.6, 2.0}, {0.1, 0.1, 0.1}}}};
  for (std::size_t i = 0; i < choice.robot_count(); ++i)
    portraits.push_back({"mixed_camera_" + std::to_string(i), (*world)->robot(i).scene(0)});
  return portraits;
}

}  // namespace
}  // namespace sinew::plant

sinew::plant::WorldType sinew::robots::describe_world_of_mixed() {
  using namespace plant;
  WorldType type;
  type.info = mixed_world();
  type.title = "humanoids and wheeled robots with grippers, a wall and an orange ball";
  // The ball's place does not matter: scenes have it.
  type.painter = [](std::uint32_t width, std::uint32_t height, const WorldChoice& choice) {
    return pitch_painter(width, height, mixed_pitch(choice, 1), mixed_bodies(choice));
  };
  type.portraits = mixed_portraits;
  type.create = [](const WorldChoice& choice, std::uint64_t seed) -> hal::Result<std::unique_ptr<World>> {
    auto made = MixedWorld::create(choice, seed);
    if (!made) return made.error();
    return std::unique_ptr<World>(std::move(*made));
  };
  return type;
}
