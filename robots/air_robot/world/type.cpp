// The AirRobot's world, for the list of worlds.
#include "robots/air_robot/devices.hpp"
#include "robots/air_robot/world/places.hpp"

namespace sinew::robots {

plant::WorldType describe_world_of_air_robot();

}  // namespace sinew::robots

namespace sinew::plant {
namespace {

PlaceNumber place_of(const WorldInfo& info, const WorldValues& values) {
  return static_cast<PlaceNumber>(static_cast<std::size_t>(info.value(values, "place").value()));
}

/// With a vehicle for each of `robots`; without any it is a place for a door that lets them come and go.
hal::Result<std::unique_ptr<World>> create_place(const WorldInfo& info, std::span<const WorldValues> robots,
                                                 std::uint64_t seed) {
  const WorldValues none, &shared = robots.empty() ? none : robots[0];
  auto map = load_place(place_of(info, shared));
  if (!map) return map.error();
  Place::Options options;
  options.seed = seed;
  options.target_mps = info.value(shared, "target_mps").value();
  options.sensor_errors = info.value(shared, "sensor_errors") != 0;
  options.wind.gust_mps = info.value(shared, "gust_mps").value();
  options.wind.steady_mps = info.value(shared, "wind_mps");
  options.has_goal = info.value(shared, "goal") != 0;
  options.spread = info.value(shared, "spread") != 0;
  auto place = std::make_unique<Place>(std::move(*map), options);
  for (std::size_t i = 0; i < robots.size(); ++i) {
    const auto number = static_cast<std::size_t>(info.value(robots[i], "start").value_or(static_cast<double>(i + 1)));
    const StartPose& start = place->map().starts[number - 1];
    const auto entered =
        place->enter(kAirRobot, Place::standing(start, kAirRobot), {seed_of_robot(seed, i), options.sensor_errors, 1});
    if (!entered) return entered.error();
  }
  return std::unique_ptr<World>(std::move(place));
}

// ---- pictures for people

struct Shown {
  const VehicleKind* kind;
  math::Vec3 p_m;
  double yaw_rad;
};

Portrait portrait(PlaceNumber number, std::string name, std::span<const Shown> shown,
                  std::optional<Viewpoint> outside) {
  auto map = load_place(number);
  if (!map) return {std::move(name), {}};
  Place place(std::move(*map), {});
  for (const Shown& s : shown) static_cast<void>(place.enter(*s.kind, {s.p_m, s.yaw_rad}, {}));
  place.advance({});
  Portrait all{std::move(name), outside ? place.bodies(kMostRobots) : place.robot(0).scene(0)};
  all.outside = outside;
  return all;
}

std::vector<Portrait> place_portraits(PlaceNumber number) {
  const double ground = kP3at.rest_m;
  switch (number) {
    case PlaceNumber::town: {
      const Shown shown[] = {{&kAirRobot, {-1.5, -3.6, 2.2}, 0.5},
                             {&kAirRobot, {1.2, -0.6, 3.6}, 0.4},
                             {&kP3at, {1.5, -3.4, ground}, 0.4}};
      const Shown high[] = {{&kAirRobot, {-14, -6, 14}, 0.35}};
      return {portrait(number, "town_camera", high, std::nullopt),
              portrait(number, "town", shown, Viewpoint{{-6.5, -8.5, 3.0}, {3.5, 3.0, 5.0}}),
              portrait(number, "town_above", shown, Viewpoint{{-70, -75, 62}, {2, 2, 6}})};
    }
    case PlaceNumber::room: {
      const Shown shown[] = {{&kAirRobot, {-1.0, 0.3, 1.2}, 0}, {&kP3at, {0.4, -0.9, ground}, 0.4}};
      return {portrait(number, "room_camera", shown, std::nullopt),
              portrait(number, "room", shown, Viewpoint{{-3.2, -2.6, 2.4}, {0.6, 0.2, 0.5}})};
    }
    case PlaceNumber::arena:
    case PlaceNumber::empty_arena:
      break;
  }
  const Shown shown[] = {{&kAirRobot, {-1.3, -0.3, 1.3}, 0.1},
                         {&kAirRobot, {3.2, -0.6, 2.6}, 2.6},
                         {&kP3at, {-4.2, -3.4, ground}, 0.3},
                         {&kP3at, {-4.6, 2.2, ground}, -0.4}};
  const std::string name = number == PlaceNumber::arena ? "arena" : "empty_arena";
  return {portrait(number, name + "_camera", shown, std::nullopt),
          portrait(number, name, shown, Viewpoint{{-9.0, -5.6, 4.6}, {0.8, -0.3, 0.3}})};
}

}  // namespace
}  // namespace sinew::plant

sinew::plant::WorldType sinew::robots::describe_world_of_air_robot() {
  using namespace plant;
  WorldType type;
  type.info = {"air_robot", kAirRobotDevices, kAirRobotWorldOptions, kMostRobots};
  type.title = "AirRobots in an arena, a town or a room";
  type.room_xml = place_xml(PlaceNumber::arena);
  type.room_of = [info = type.info](const WorldValues& values) { return place_xml(place_of(info, values)); };
  type.create = [info = type.info](const WorldChoice& choice, std::uint64_t seed) {
    return create_place(info, choice.all_values(), seed);
  };
  type.portraits = [info = type.info](const WorldChoice& choice) {
    return place_portraits(place_of(info, choice.values));
  };
  return type;
}
