// The quadrotor's world, for the list of worlds.
#include "math/linear.hpp"
#include "robots/quad/world/quad_world.hpp"
#include "robots/quad/world/room_xml.hpp"
#include "sim_hil/worlds/vec.hpp"

namespace sinew::robots {

plant::WorldType describe_world_of_quad();

}  // namespace sinew::robots

namespace sinew::plant {
namespace {

CameraPose camera_at(const msg::Vec3& base, const msg::Quat& q_world_base) {
  return {add(base, Rotation(q_world_base).apply(kCameraPBase)), mul(q_world_base, kCameraQBaseOptical)};
}

Scene through_camera(const msg::Vec3& base, const msg::Quat& q_world_base) {
  const msg::Quat q = math::Quat(q_world_base).normalized().to<msg::Quat>();
  Scene scene;
  scene.camera = camera_at(base, q);
  return scene;
}

Scene with_vehicle(const msg::Vec3& base, const msg::Quat& q_world_base) {
  Scene scene;
  scene.vehicle[0] = {base, q_world_base};
  scene.vehicles = 1;
  scene.rotors_turn = base.z > kFeetBelowBase;
  return scene;
}

/// Camera views at the heights of a flight, and the vehicle from outside.
std::vector<Portrait> portraits() {
  return {
      {"camera_start", through_camera({0.7, 0.4, 0.12}, {})},
      {"camera_0.3m", through_camera({0.02, 0, 0.3}, {})},
      {"camera_1.5m", through_camera({0.4, -0.2, 1.5}, {0.98, 0.02, -0.03, 0.19})},
      {"camera_3m", through_camera({-0.6, 0.5, 3.0}, {})},
      {"flight", with_vehicle({0.12, -0.02, 0.62}, {0.9957, 0.035, -0.055, 0.065}),
       Viewpoint{{-0.70, -0.80, 1.02}, {0.12, 0.0, 0.36}}},
      {"room", with_vehicle({0.2, 0.1, 1.6}, {1, 0, 0, 0}), Viewpoint{{-3.5, -3.4, 2.6}, {0.5, 0.5, 0.8}}},
      {"landed", with_vehicle({0.03, -0.02, 0.12}, {0.98, 0, 0, 0.199}), Viewpoint{{0.75, -0.8, 0.55}, {0, 0, 0.08}}}};
}

QuadOptions options_of(const WorldInfo& info, const WorldValues& values, std::uint64_t seed) {
  const auto radians = [&](const char* key) {
    const auto deg = info.value(values, key);
    return deg ? std::optional(*deg * math::kPi / 180) : std::nullopt;
  };
  QuadOptions quad;
  quad.seed = seed;
  quad.gust_mps = info.value(values, "gust_mps").value();
  quad.wind_mps = info.value(values, "wind_mps");
  quad.wind_toward_rad = radians("wind_toward_deg");
  quad.spread = info.value(values, "spread").value();
  quad.start_offset_m = info.value(values, "start_offset_m").value();
  quad.start_x_m = info.value(values, "start_x_m");
  quad.start_y_m = info.value(values, "start_y_m");
  quad.start_heading_rad = radians("start_yaw_deg");
  quad.land_x_m = info.value(values, "land_x_m").value();
  quad.land_y_m = info.value(values, "land_y_m").value();
  quad.battery_charge = info.value(values, "battery_charge");
  quad.sensor_errors = info.value(values, "sensor_errors") != 0;
  return quad;
}

}  // namespace
}  // namespace sinew::plant

sinew::plant::WorldType sinew::robots::describe_world_of_quad() {
  using namespace plant;
  WorldType type;
  type.info = QuadWorld::info();
  type.title = "a quadrotor in a room with a landing pad";
  type.room_xml = room_xml_of_quad();
  type.create = [info = type.info](const WorldChoice& choice,
                                   std::uint64_t seed) -> hal::Result<std::unique_ptr<World>> {
    std::vector<QuadOptions> quads;
    for (std::size_t i = 0; i < choice.robot_count(); ++i)
      quads.push_back(options_of(info, choice.values_of(i), seed_of_robot(seed, i)));
    auto made = QuadWorld::create(quads);
    if (!made) return made.error();
    return std::unique_ptr<World>(std::move(*made));
  };
  type.portraits = [](const WorldChoice&) { return portraits(); };
  return type;
}
