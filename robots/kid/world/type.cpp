// The world "soccer", for the list of worlds.
#include "robots/kid/world/soccer_world.hpp"

namespace sinew::robots {

plant::WorldType describe_world_of_kid();

}  // namespace sinew::robots

namespace sinew::plant {
namespace {

/// Robots that stand, from outside and through their cameras.
std::vector<Portrait> soccer_portraits(const WorldChoice& choice) {
  const auto world = choice.create(1);
  if (!world) return {};
  const std::vector<double> upright(choice.type->info.channels(Part::actuators), 0);
  const std::vector<RobotCommand> all(choice.robot_count(), RobotCommand(upright));
  for (int i = 0; i < 1200; ++i) (*world)->advance(all);
  std::vector<Portrait> portraits{
      {"soccer", (*world)->robot(0).scene(0), Viewpoint{{-3.4, -2.6, 1.5}, {0.2, 0.2, 0.1}}},
      {"soccer_close", (*world)->robot(0).scene(0), Viewpoint{{-0.2, -0.9, 0.5}, {-0.9, 0.1, 0.22}}}};
  for (std::size_t i = 0; i < choice.robot_count(); ++i)
    portraits.push_back({"soccer_camera_" + std::to_string(i), (*world)->robot(i).scene(0)});
  return portraits;
}

}  // namespace
}  // namespace sinew::plant

sinew::plant::WorldType sinew::robots::describe_world_of_kid() {
  using namespace plant;
  WorldType type;
  type.info = SoccerWorld::info();
  type.title = "humanoids on a soccer field";
  type.painter = soccer_painter;
  type.portraits = soccer_portraits;
  type.create = [](const WorldChoice& choice, std::uint64_t seed) -> hal::Result<std::unique_ptr<World>> {
    auto made = SoccerWorld::create(choice, seed);
    if (!made) return made.error();
    return std::unique_ptr<World>(std::move(*made));
  };
  return type;
}
