// The terrain's world, for the list of worlds.
#include "math/linear.hpp"
#include "robots/quad/world/vehicle.hpp"
#include "robots/terrain/devices.hpp"
#include "robots/terrain/world/terrain_world.hpp"
#include "sim_hil/worlds/vec.hpp"

namespace sinew::robots {

plant::WorldType describe_world_of_terrain();

}  // namespace sinew::robots

namespace sinew::plant {
namespace {

TerrainOptions terrain_options(const WorldInfo& info, const WorldValues& values, std::uint64_t seed) {
  TerrainOptions o;
  o.terrain = static_cast<Terrain>(static_cast<int>(info.value(values, "terrain").value()));
  o.motion_radps = info.value(values, "motion_radps").value();
  o.quad.seed = seed;
  o.quad.gust_mps = info.value(values, "gust_mps").value();
  o.quad.wind_mps = info.value(values, "wind_mps");
  if (const auto deg = info.value(values, "wind_toward_deg")) o.quad.wind_toward_rad = *deg * math::kPi / 180;
  o.quad.spread = info.value(values, "spread").value();
  o.quad.battery_charge = info.value(values, "battery_charge");
  o.quad.sensor_errors = info.value(values, "sensor_errors") != 0;
  return o;
}

Scene above(Terrain terrain, double x_m, double height_m) {
  const msg::Vec3 base{x_m, lane_m(terrain), ground_m(terrain, x_m, 0) + height_m};
  Scene scene;
  scene.camera = {add(base, kCameraPBase), kCameraQBaseOptical};
  scene.vehicle[0] = {base, {}};
  scene.vehicles = 1;
  scene.rotors_turn = true;
  return scene;
}

std::vector<Portrait> terrain_portraits() {
  const auto outside = [](Terrain t, double x_m) {
    const double y = lane_m(t);
    return Viewpoint{{x_m - 4.5, y - 5.5, 4.5}, {x_m + 2.5, y, 1.2}};
  };
  return {{"camera_start", above(Terrain::hills, 4, 2)},
          {"camera_hills", above(Terrain::hills, 30, 2)},
          {"camera_steps", above(Terrain::steps, 28, 2)},
          {"camera_buildings", above(Terrain::buildings, 30, 2)},
          {"hills", above(Terrain::hills, 30, 2), outside(Terrain::hills, 30)},
          {"steps", above(Terrain::steps, 28, 2), outside(Terrain::steps, 28)},
          {"buildings", above(Terrain::buildings, 22, 2), outside(Terrain::buildings, 22)}};
}

}  // namespace
}  // namespace sinew::plant

sinew::plant::WorldType sinew::robots::describe_world_of_terrain() {
  using namespace plant;
  static const std::string room = terrain_room();
  WorldType type;
  type.info = {"terrain", kQuadDevices, kTerrainWorldOptions};
  type.title = "a quadrotor over hills, steps and buildings";
  type.room_xml = room;
  type.create = [info = type.info](const WorldChoice& choice,
                                   std::uint64_t seed) -> hal::Result<std::unique_ptr<World>> {
    auto made = TerrainWorld::create(terrain_options(info, choice.values_of(0), seed));
    if (!made) return made.error();
    return std::unique_ptr<World>(std::move(*made));
  };
  type.portraits = [](const WorldChoice&) { return terrain_portraits(); };
  return type;
}
