#include "sim_hil/places/place.hpp"

#include <algorithm>

namespace sinew::plant {

using math::Vec3;

namespace {

constexpr double kPlaceStep_s = 1e-9 * kStepNs;
constexpr Vec3 kNowhere{0, 0, -1000};  // bodies that are not there: far below what any camera sees

Pose pose_of(const Vec3& p, const math::Quat& q) { return {p.to<msg::Vec3>(), q.to<msg::Quat>()}; }

Solid solid_of(const Thing& thing) {
  return {Shape::box,
          Vec3(thing.pose.p_world_m),
          math::Quat(thing.pose.q_world),
          {kThing_m / 2, kThing_m / 2, kThing_m / 2}};
}

}  // namespace

Place::Place(PlaceMap map, const Options& options)
    : map_(std::move(map)), options_(options), wind_(options.wind, options.seed) {
  target_m_ = has_target() ? map_.target_way[0] : kNowhere;
  if (options_.spread) spread();
  list_moving();
}

void Place::spread() {
  constexpr double kBeside_m = 0.5;
  math::Random random(options_.seed, 0x73707264);
  for (StartPose& start : map_.starts) {
    start.ground_m += {random.uniform(-kBeside_m, kBeside_m), random.uniform(-kBeside_m, kBeside_m), 0};
    start.yaw_rad = random.uniform(-math::kPi, math::kPi);
  }
  auto& way = map_.target_way;
  if (way.size() < 2) return;
  std::rotate(way.begin(),
              way.begin() + static_cast<std::ptrdiff_t>(random.below(static_cast<std::uint32_t>(way.size()))),
              way.end());
  if (random.below(2) == 1) std::ranges::reverse(way);
  target_m_ = way[0] + random.uniform(0, 1) * (way[1] - way[0]);
}

hal::Result<std::size_t> Place::enter(const VehicleKind& kind, const Vehicle::Start& start,
                                      const Vehicle::Options& options) {
  const auto free = std::ranges::find_if(vehicles_, [](const auto& v) { return !v; });
  if (free == vehicles_.end()) return hal::Error{hal::Errc::busy, "all vehicles of the place are taken"};
  const Vec3 hull = start.p_world_m + Vec3{0, 0, kind.hull_up_m};
  bool clear = true;
  around(nullptr).near(hull, kind.hull_radius_m, [&](const Solid& s) {
    if (clearance(s, hull).distance_m < kind.hull_radius_m - 0.02) clear = false;
  });
  if (!clear) return hal::Error{hal::Errc::bad_argument, "something is in the way there"};
  const auto slot = static_cast<std::size_t>(free - vehicles_.begin());
  *free = std::make_unique<Vehicle>(*this, slot, kind, start, options);
  list_moving();
  return slot;
}

void Place::leave(std::size_t slot) {
  vehicles_[slot].reset();
  list_moving();
}

const StartPose* Place::find_start(std::string_view name) const {
  const auto found = std::ranges::find(map_.starts, name, &StartPose::name);
  return found == map_.starts.end() ? nullptr : &*found;
}

Vehicle::Start Place::standing(const StartPose& pose, const VehicleKind& kind) {
  return {pose.ground_m + Vec3{0, 0, kind.rest_m}, pose.yaw_rad};
}

// ---- things

hal::Status Place::create(std::size_t kind, std::string_view name, const Pose& pose) {
  if (find_thing(name)) return hal::Error{hal::Errc::busy, "there is a thing of this name"};
  std::array<bool, kMostOfAKind> taken{};
  for (const Thing& t : things_)
    if (t.kind == kind) taken[t.number] = true;
  const auto free = std::ranges::find(taken, false);
  if (free == taken.end()) return hal::Error{hal::Errc::busy, "all things of this kind are there"};
  things_.push_back({std::string(name), kind, static_cast<std::size_t>(free - taken.begin()), pose});
  list_moving();
  return {};
}

Thing* Place::find_thing(std::string_view name) {
  const auto found = std::ranges::find(things_, name, &Thing::name);
  return found == things_.end() ? nullptr : &*found;
}

bool Place::remove(std::string_view name) {
  const bool was_there = std::erase_if(things_, [&](const Thing& t) { return t.name == name; }) > 0;
  list_moving();
  return was_there;
}

void Place::remove_all() {
  things_.clear();
  list_moving();
}

void Place::put_target(const Vec3& p_world_m) {
  target_m_ = p_world_m;
  target_moves_ = false;
}

void Place::move_target(double dt_s) {
  if (!target_moves_ || map_.target_way.size() < 2) return;
  double left_m = options_.target_mps * dt_s;
  for (std::size_t legs = 0; left_m > 0 && legs < map_.target_way.size(); ++legs) {
    const Vec3& next = map_.target_way[(target_leg_ + 1) % map_.target_way.size()];
    const Vec3 to = next - target_m_;
    const double far = math::norm(to);
    if (far > left_m) {
      target_m_ += (left_m / far) * to;
      return;
    }
    target_m_ = next;
    left_m -= far;
    target_leg_ = (target_leg_ + 1) % map_.target_way.size();
  }
}

// ---- what there is

void Place::list_moving() {
  moving_.resize(kMostRobots + 1);
  for (std::size_t i = 0; i < kMostRobots; ++i)
    moving_[i] = vehicles_[i] ? vehicles_[i]->hull() : Solid{Shape::sphere, kNowhere, {}, {}};
  moving_[kMostRobots] = {Shape::sphere, target_m_, {}, {map_.target_radius_m, 0, 0}};
  for (const Thing& t : things_) moving_.push_back(solid_of(t));
}

Surroundings Place::around(const Vehicle* self) const {
  return {map_.solids, moving_, self ? &moving_[self->slot()] : nullptr};
}

std::optional<Hit> Place::beam(const Vehicle& from_whom, const Vec3& from, const Vec3& direction, double most_m) const {
  return around(&from_whom).beam(from, direction, most_m);
}

std::size_t Place::satellites(const Vec3& from) const {
  // Three rings of elevation, as a sky with evenly spread satellites has them.
  constexpr double kElevation_rad[] = {0.35, 0.7, 1.1};
  constexpr std::size_t kRings = std::size(kElevation_rad);
  std::size_t seen = 0;
  for (std::size_t i = 0; i < kSatellites; ++i) {
    const math::SinCos up = math::sincos(kElevation_rad[i % kRings]);
    const math::SinCos round = math::sincos(2 * math::kPi * static_cast<double>(i) / kSatellites);
    constexpr double kSky_m = 500;
    if (!around(nullptr).beam(from + Vec3{0, 0, 1}, {up.cos * round.cos, up.cos * round.sin, up.sin}, kSky_m)) ++seen;
  }
  return seen;
}

Scene Place::bodies(std::size_t unseen) const {
  Scene scene;
  scene.bodies = SceneOrder::kBodies;
  for (std::size_t i = 0; i < scene.bodies; ++i) scene.body[i] = pose_of(kNowhere, {});
  for (std::size_t i = 0; i < kMostRobots; ++i) {
    const Vehicle* v = vehicles_[i].get();
    if (!v || i == unseen) continue;
    const bool flies = v->kind().locomotion == Locomotion::rotors;
    const std::size_t drawn = v->kind().steers() ? SceneOrder::kSteered : SceneOrder::kWheeled;
    scene.body[(flies ? SceneOrder::kFlying : drawn) + i] = pose_of(v->body().p_world_m, v->body().q_world_base());
  }
  scene.body[SceneOrder::kTarget] = pose_of(target_m_, {});
  for (const Thing& t : things_) scene.body[SceneOrder::kThings + t.kind * kMostOfAKind + t.number] = t.pose;
  return scene;
}

// ---- World

std::size_t Place::robots() const {
  return static_cast<std::size_t>(std::ranges::count_if(vehicles_, [](const auto& v) { return v != nullptr; }));
}

void Place::advance(std::span<const RobotCommand> commands) {
  for (std::size_t i = 0; i < commands.size() && i < kMostRobots; ++i)
    if (vehicles_[i]) vehicles_[i]->take(commands[i]);
  wind_.step(kPlaceStep_s);
  move_target(kPlaceStep_s);
  list_moving();
  for (const auto& v : vehicles_)
    if (v) {
      v->step(around(v.get()), kPlaceStep_s);
      moving_[v->slot()] = v->hull();
    }
  ++steps_;
  for (const auto& v : vehicles_)
    if (v) v->sample(steps_, around(v.get()));
}

}  // namespace sinew::plant
