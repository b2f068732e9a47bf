// The head's world, for the list of worlds.
#include "robots/desk_head/world/head_body.hpp"
#include "robots/desk_head/world/head_world.hpp"
#include "robots/desk_head/world/room_xml.hpp"

namespace sinew::robots {

plant::WorldType describe_world_of_desk_head();

}  // namespace sinew::robots

namespace sinew::plant {
namespace {

/// Pan and tilt that point the head at the ball.
std::array<double, kHeadJoints> aim(const HeadWorld& world) {
  const math::Quat q_base = world.q_world_base();
  const math::Vec3 neck = kPivot + q_base.rotate(kPBaseYoke + kPYokeHead);
  const math::Vec3 d = q_base.conjugate().rotate(world.ball_m() - neck);
  return {math::atan2(d.y, d.x), math::atan2(-d.z, math::hypot(d.x, d.y))};
}

/// Views of a head that knows where the ball is: from outside and through its camera.
std::vector<Portrait> portraits() {
  HeadWorld world({.seed = 1});
  const auto advance = [&](double seconds) {
    for (int i = 0; i < static_cast<int>(seconds * 4000); ++i) {
      const auto command = aim(world);
      world.step(command);
    }
  };
  advance(3.0);
  std::vector<Portrait> all{{"desk_head", world.scene(0), Viewpoint{{-0.75, -0.95, 1.50}, {0.55, 0.10, 0.98}}},
                            {"desk_head_close", world.scene(0), Viewpoint{{0.55, -0.55, 1.12}, {0.0, 0.0, 0.93}}}};
  for (int i = 0; i < 6; ++i) {
    all.push_back({"desk_head_camera_" + std::to_string(i), world.scene(0)});
    advance(1.7);
  }
  return all;
}

}  // namespace
}  // namespace sinew::plant

sinew::plant::WorldType sinew::robots::describe_world_of_desk_head() {
  using namespace plant;
  WorldType type;
  type.info = HeadWorld::info();
  type.title = "a head on a desk that follows a ball";
  type.room_xml = room_xml_of_desk_head();
  type.create = [info = type.info](const WorldChoice& choice,
                                   std::uint64_t seed) -> hal::Result<std::unique_ptr<World>> {
    const WorldValues values = choice.values_of(0);
    HeadOptions head;
    head.seed = seed;
    head.rock_deg = info.value(values, "rock_deg").value();
    head.ball_speed = info.value(values, "ball_speed").value();
    head.pillar = info.value(values, "pillar") != 0;
    head.sensor_errors = info.value(values, "sensor_errors") != 0;
    return std::unique_ptr<World>(std::make_unique<HeadWorld>(head));
  };
  type.portraits = [](const WorldChoice&) { return portraits(); };
  return type;
}
