#include "robots/mixed/world/mixed_world.hpp"

#include <algorithm>

#include "math/random.hpp"
#include "robots/kid/world/soccer_world.hpp"
#include "sim_hil/pitch/painter.hpp"
#include "sim_hil/worlds/json_object.hpp"

namespace sinew::plant {
namespace {

constexpr std::int64_t kStepsOfPitch = kPitchStepNs / kStepNs;
constexpr std::uint32_t kBallStream = 0x6d697862;
constexpr double kNearest_x_m = 0.5, kFarthest_x_m = 1.7, kAside_m = 0.6;

}  // namespace

/// A robot of this world: what its kind does, with the verdict of the team.
class MixedRobot final : public SimRobot {
 public:
  MixedRobot(std::unique_ptr<PitchRobot> side, const MixedWorld& world) : side_(std::move(side)), world_(world) {}
  PitchRobot& side() { return *side_; }

  const Due& due() const override { return side_->due(); }
  WorldTruth ground_truth() const override { return side_->ground_truth(); }
  Scene scene(std::size_t camera) const override { return side_->scene(camera); }
  bool still() const override { return side_->still(); }
  std::uint32_t news() const override { return side_->news(); }
  void add_to(JsonObject& report) const override {
    side_->add_to(report);
    world_.add_to(report);
  }
  Verdict verdict() const override {
    Verdict v = world_.verdict();
    v.begun = side_->verdict().begun;
    return v;
  }
  std::string outcome() const override { return world_.verdict().outcome + "; " + side_->outcome(); }
  PlantJoints* joints() override { return side_->joints(); }

 private:
  std::unique_ptr<PitchRobot> side_;
  const MixedWorld& world_;
};

PitchOptions mixed_pitch(const WorldChoice& choice, std::uint64_t seed) {
  const WorldInfo& info = choice.type->info;
  const auto value = [&](const char* key) { return info.value(choice.values, key); };
  PitchOptions options;
  options.ground = GroundErrors::from(choice.values);
  options.orange_ball = true;
  math::Random random(seed, kBallStream);
  const double drawn_x = random.uniform(kNearest_x_m, kFarthest_x_m), drawn_y = random.uniform(-kAside_m, kAside_m);
  options.ball_at.x_m = value("ball_x_m").value_or(drawn_x);
  options.ball_at.y_m = value("ball_y_m").value_or(drawn_y);
  options.wall = {value("wall_high_m").value(), value("wall_x_m").value(), value("wall_from_y_m").value(),
                  value("wall_to_y_m").value()};
  if (options.wall.to_y_m <= options.wall.from_y_m) options.wall.high_m = 0;
  return options;
}

std::vector<PitchBody> mixed_bodies(const WorldChoice& choice) {
  std::vector<PitchBody> bodies;
  for (std::size_t i = 0; i < choice.robot_count(); ++i) {
    bodies.push_back(soccer_robot_of(choice, i).body);
    if (choice.info_of(i).has_bodies) continue;
    const PitchPlace start = bodies.back().start;
    bodies.back() = gripper_body(choice.type->info, choice.values_of(i));
    bodies.back().start = start;
  }
  return bodies;
}

hal::Result<std::unique_ptr<MixedWorld>> MixedWorld::create(const WorldChoice& choice, std::uint64_t seed) {
  auto pitch = Pitch::create(mixed_pitch(choice, seed), mixed_bodies(choice), seed);
  if (!pitch) return pitch.error();
  return std::unique_ptr<MixedWorld>(new MixedWorld(std::move(*pitch), choice, seed));
}

MixedWorld::MixedWorld(std::unique_ptr<Pitch> pitch, const WorldChoice& choice, std::uint64_t seed)
    : pitch_(std::move(pitch)) {
  const auto value = [&](const char* key) { return choice.type->info.value(choice.values, key).value(); };
  goal_m_ = {value("goal_x_m"), value("goal_y_m"), 0};
  for (std::size_t i = 0; i < choice.robot_count(); ++i) {
    std::unique_ptr<PitchRobot> side;
    const GripperOnPitch* gripper = nullptr;
    if (choice.info_of(i).has_bodies) {
      side = kid_on_pitch(soccer_robot_of(choice, i), *pitch_, i, seed_of_robot(seed, i));
    } else {
      auto made = std::make_unique<GripperOnPitch>(*pitch_, i, goal_m_);
      gripper = made.get();
      side = std::move(made);
    }
    grippers_.push_back(gripper);
    robots_.push_back(std::make_unique<MixedRobot>(std::move(side), *this));
  }
}

MixedWorld::~MixedWorld() = default;
std::size_t MixedWorld::robots() const { return robots_.size(); }
SimRobot& MixedWorld::robot(std::size_t number) { return *robots_[number]; }

void MixedWorld::advance(std::span<const RobotCommand> commands) {
  const bool moves = steps_ % kStepsOfPitch == kStepsOfPitch - 1;
  ++steps_;
  if (!moves) {
    for (const auto& robot : robots_) robot->side().nothing_due();
    return;
  }
  for (std::size_t i = 0; i < robots_.size(); ++i) robots_[i]->side().act(commands[i], pitch_->now_ns());
  pitch_->step();
  for (const auto& robot : robots_) robot->side().sample(steps_);
  const double now_s = 1e-9 * static_cast<double>(steps_ * kStepNs);
  if (gripped_s_ < 0 && any_holds()) gripped_s_ = now_s;
  if (gripped_s_ >= 0 && brought_s_ < 0 && verdict().good) brought_s_ = now_s;
}

// ---- what is so

double MixedWorld::error_m() const {
  const math::Vec3& ball = pitch_->ball().p_m;
  return math::hypot(ball.x - goal_m_.x, ball.y - goal_m_.y);
}

bool MixedWorld::any_holds() const {
  return std::ranges::any_of(grippers_, [](const GripperOnPitch* g) { return g && g->score().holds(); });
}

/// Who has brought it; null: nobody.
const GripperOnPitch* MixedWorld::carrier() const {
  const auto it = std::ranges::find_if(
      grippers_, [](const GripperOnPitch* g) { return g && g->score().grips() > 0 && g->score().verdict().good; });
  return it == grippers_.end() ? nullptr : *it;
}

Verdict MixedWorld::verdict() const {
  std::uint32_t grips = 0;
  for (const GripperOnPitch* g : grippers_) grips += g ? g->score().grips() : 0;
  Verdict v;
  v.good = carrier() && !any_holds();
  if (v.good)
    v.outcome = "the object is at the goal";
  else if (any_holds())
    v.outcome = "the object is held";
  else if (grips > 0)
    v.outcome = "the object was held, and is not at the goal";
  else
    v.outcome = "nobody has held the object";
  v.measures = {{"object_from_goal_m", "object from the goal", "m", error_m(), 0.5},
                {"grips_of_all", "grips of all", "", static_cast<double>(grips)}};
  return v;
}

void MixedWorld::add_to(JsonObject& report) const {
  report.number("object_from_goal_m", error_m());
  report.number("gripped_at_s", gripped_s_);
  report.number("brought_at_s", brought_s_);
  const GripperOnPitch* by = carrier();
  report.number("brought_by", by ? static_cast<double>(std::ranges::find(grippers_, by) - grippers_.begin()) : -1);
}

}  // namespace sinew::plant
