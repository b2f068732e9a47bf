// The world "gripper", for the list of worlds.
#include "robots/gripper/world/gripper_world.hpp"
#include "sim_hil/pitch/painter.hpp"

namespace sinew::robots {

plant::WorldType describe_world_of_gripper();

}  // namespace sinew::robots

namespace sinew::plant {
namespace {

/// From outside, and through its camera.
std::vector<Portrait> gripper_portraits(const WorldChoice& choice) {
  auto world = choice.create(1);
  if (!world) return {};
  for (int i = 0; i < 1200; ++i) (*world)->step({});
  const Scene scene = (*world)->robot(0).scene(0);
  return {{"gripper", scene, Viewpoint{{-2.6, -1.5, 0.9}, {-1.0, 0.1, 0.1}}}, {"gripper_camera", scene}};
}

}  // namespace
}  // namespace sinew::plant

sinew::plant::WorldType sinew::robots::describe_world_of_gripper() {
  using namespace plant;
  WorldType type;
  type.info = GripperWorld::info();
  type.title = "a wheeled robot with a gripper on a soccer field";
  // The ball's place does not matter: scenes have it.
  type.painter = [](std::uint32_t width, std::uint32_t height, const WorldChoice& choice) {
    const PitchBody body = gripper_body(choice.type->info, choice.values);
    return pitch_painter(width, height, gripper_pitch(choice.type->info, choice.values, 1), {&body, 1});
  };
  type.portraits = gripper_portraits;
  type.create = [](const WorldChoice& choice, std::uint64_t seed) -> hal::Result<std::unique_ptr<World>> {
    auto made = GripperWorld::create(choice, seed);
    if (!made) return made.error();
    return std::unique_ptr<World>(std::move(*made));
  };
  return type;
}
