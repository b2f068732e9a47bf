#pragma once
// A place with vehicles that come and go, things that can be put there, and a target that moves. It knows no protocol:
// doors (sim_hil/plant, sim_hil/usarsim) let robots in.
#include <memory>
#include <string>
#include <vector>

#include "sim_hil/places/vehicle.hpp"
#include "sim_hil/worlds/wind.hpp"

namespace sinew::plant {

/// Somewhere to begin: on the ground, by name.
struct StartPose {
  std::string name;
  math::Vec3 ground_m;
  double yaw_rad = 0;
};

/// What a place is made of.
struct PlaceMap {
  std::string name;
  std::vector<Solid> solids;
  std::vector<StartPose> starts;
  std::vector<math::Vec3> target_way;  // the target goes round it; empty: there is none
  double target_radius_m = 0.25;
  double latitude_deg = 0, longitude_deg = 0;  // of its origin; x is east, y north
};

/// Kinds of things that can be put into a place: crates of one size, in four colours.
struct ThingKind {
  const char* name = "";
};
inline constexpr ThingKind kThingKinds[] = {{"crate"}, {"red crate"}, {"green crate"}, {"blue crate"}};
inline constexpr std::size_t kMostOfAKind = 3;
inline constexpr double kThing_m = 0.40;  // its edges

struct Thing {
  std::string name;
  std::size_t kind = 0;    // of kThingKinds
  std::size_t number = 0;  // among its kind
  Pose pose;               // of its middle
};

/// The places of moving bodies in Scene::body, in this order: flying vehicles, skid-steered ones, the target, things by
/// kind, vehicles with axles that steer.
struct SceneOrder {
  static constexpr std::size_t kFlying = 0, kWheeled = kMostRobots, kTarget = 2 * kMostRobots, kThings = kTarget + 1;
  static constexpr std::size_t kSteered = kThings + std::size(kThingKinds) * kMostOfAKind;
  static constexpr std::size_t kBodies = kSteered + kMostRobots;
};
static_assert(SceneOrder::kBodies <= Scene::kMost);

/// As a World, its robots are the vehicles of its own protocol's sessions: number i is the i-th that entered and none
/// of them leaves. A door that lets vehicles come and go uses slots. Same commands at the same steps give the same
/// bytes. Thread:  owner.
class Place final : public World {
 public:
  struct Options {
    std::uint64_t seed = 1;
    double target_mps = 0;
    bool sensor_errors = true;
    WindOptions wind{};
    /// Where on its way the target begins, which way round it goes, where start poses are and look: by the seed.
    bool spread = false;
    bool has_goal = false;  // a vehicle's run is good only if it kept the target in view and reached it
  };
  Place(PlaceMap map, const Options& options);

  const PlaceMap& map() const { return map_; }
  const Options& options() const { return options_; }

  // ---- vehicles, by slot (< kMostRobots)
  /// Errors:  busy: all slots are taken; bad_argument: something is in the way there.
  hal::Result<std::size_t> enter(const VehicleKind& kind, const Vehicle::Start& start, const Vehicle::Options& options);
  /// Its place is free at once.
  void leave(std::size_t slot);
  /// Null: the slot is free.
  Vehicle* vehicle(std::size_t slot) { return vehicles_[slot].get(); }
  const Vehicle* vehicle(std::size_t slot) const { return vehicles_[slot].get(); }
  /// Base of a vehicle of this kind that stands there. Nothing: no such pose.
  const StartPose* find_start(std::string_view name) const;
  static Vehicle::Start standing(const StartPose& pose, const VehicleKind& kind);

  // ---- things
  /// Errors:  busy: all of this kind are there, or the name is taken.
  hal::Status create(std::size_t kind, std::string_view name, const Pose& pose);
  Thing* find_thing(std::string_view name);
  bool remove(std::string_view name);
  void remove_all();
  const std::vector<Thing>& things() const { return things_; }

  // ---- the target
  bool has_target() const { return !map_.target_way.empty(); }
  math::Vec3 target_m() const { return target_m_; }
  math::Vec3 wind_mps() const { return math::Vec3(wind_.velocity_mps()); }
  /// From here on it stands there.
  void put_target(const math::Vec3& p_world_m);

  // ---- what sensors see
  /// The nearest surface along a beam that begins at this vehicle.
  std::optional<Hit> beam(const Vehicle& from_whom, const math::Vec3& from, const math::Vec3& direction,
                          double most_m) const;
  /// How many of kSatellites nothing hides.
  static constexpr std::size_t kSatellites = 12;
  std::size_t satellites(const math::Vec3& from) const;
  /// The moving bodies, without the vehicle in `unseen` (kMostRobots: all).
  Scene bodies(std::size_t unseen) const;

  // ---- World
  void advance(std::span<const RobotCommand> commands) override;
  msg::Time now() const override { return {steps_ * kStepNs}; }
  std::size_t robots() const override;
  SimRobot& robot(std::size_t number) override { return *vehicles_[number]; }

 private:
  Surroundings around(const Vehicle* self) const;
  void spread();
  void move_target(double dt_s);
  void list_moving();

  PlaceMap map_;
  Options options_;
  Wind wind_;
  std::array<std::unique_ptr<Vehicle>, kMostRobots> vehicles_;
  std::vector<Thing> things_;
  std::vector<Solid> moving_;  // vehicles by slot, the target, things
  math::Vec3 target_m_;
  std::size_t target_leg_ = 0;
  bool target_moves_ = true;
  std::int64_t steps_ = 0;
};

}  // namespace sinew::plant
