#include "sim_hil/simspark/arena.hpp"

#include <algorithm>

#include "sim_hil/simspark/frame.hpp"

namespace sinew::simspark {
namespace {

using math::Vec3;
using wire::SparkPercepts;

constexpr double kStep_s = 1e-9 * plant::kPitchStepNs;
constexpr double kHold_per_s = 40;  // speed for a radian of error: what holds a joint where it was told to stand
constexpr double kParkY_m = -10.7, kParkStep_m = 1.2;
constexpr double kBeamNoise_m = 0.05, kBeamNoise_deg = 10;
constexpr double kHearing_m = 50;
constexpr int kHearEvery = 2, kSeeEvery = 3;  // cycles
constexpr double kMark_s = 0.5, kUpright_rad = 0.5;
constexpr std::uint32_t kPlayerStream = 0x73706b70;

std::size_t link_or_torso(const kinematics::Body& body, std::size_t joint) {
  return joint + 1 < body.links.size() ? joint + 1 : 0;
}

std::array<double, 3> triple(const Vec3& v) { return {v.x, v.y, v.z}; }

}  // namespace

std::unique_ptr<SparkArena> SparkArena::create(const ArenaOptions& o, std::string& why) {
  const auto map = SparkJointMap::of(*o.body, why);
  if (!map) return nullptr;
  std::unique_ptr<SparkArena> arena(new SparkArena(o, *map));
  arena->body_ = *o.body;
  arena->options_.body = &arena->body_;
  plant::PitchOptions pitch;
  pitch.ground = plant::GroundErrors::none();
  pitch.field = kSparkField;
  pitch.ball = kSparkBall;
  std::vector<plant::PitchBody> bodies;
  for (std::size_t i = 0; i < o.players; ++i) {
    plant::PitchBody body;
    body.body = arena->body_;
    body.errors = plant::BodyErrors::none();
    body.start.x_m = kParkStep_m * (static_cast<double>(i) - static_cast<double>(o.players - 1) / 2);
    body.start.y_m = kParkY_m;
    bodies.push_back(std::move(body));
  }
  auto made = plant::Pitch::create(pitch, bodies, o.seed, &why);
  if (!made) {
    if (why.empty()) why = "MuJoCo refuses the body";
    return nullptr;
  }
  arena->pitch_ = std::move(*made);
  arena->slot_.resize(o.players);
  arena->sole_ = plant::soles_of(arena->body_);
  const auto camera =
      std::ranges::find_if(arena->body_.places, [](const auto& p) { return p.name.starts_with("camera"); });
  if (camera == arena->body_.places.end()) {
    arena->eye_link_ = link_or_torso(arena->body_, map->joint(1));
  } else {
    arena->eye_link_ = camera->link;
    arena->eye_in_link_.p_m = camera->pose.p_m;  // SimSpark's eye looks along the head
  }
  return arena;
}

std::optional<std::size_t> SparkArena::enter(std::string_view name, std::uint32_t number, std::string& why) {
  const auto known = std::ranges::find(team_, name);
  const auto free_team = std::ranges::find(team_, std::string());
  const auto at = known != team_.end() ? known : free_team;
  if (at == team_.end()) {
    why = "no third team beside " + team_[0] + " and " + team_[1];
    return std::nullopt;
  }
  const Team team = at == team_.begin() ? Team::left : Team::right;
  const auto has = [&](std::uint32_t n) { return find(team, n).has_value(); };
  if (number == 0)
    for (number = 1; number <= kMostOfTeam && has(number);) ++number;
  if (number > kMostOfTeam || has(number)) {
    why = "number " + std::to_string(number) + (number > kMostOfTeam ? ": a team has 11 players" : " is taken");
    return std::nullopt;
  }
  const auto slot = std::ranges::find(slot_, false, &Slot::taken);
  if (slot == slot_.end()) {
    why = "all " + std::to_string(slot_.size()) + " bodies are taken";
    return std::nullopt;
  }
  *at = name;
  *slot = Slot{};
  slot->taken = true;
  slot->team = team;
  slot->number = number;
  slot->random = math::Random(options_.seed, kPlayerStream, ++entered_);
  slot->vision.emplace(slot->random);
  return static_cast<std::size_t>(slot - slot_.begin());
}

void SparkArena::leave(std::size_t slot) {
  Slot& s = slot_[slot];
  const Team team = s.team;
  const PlayerCounts counts = s.counts;
  s = Slot{};
  s.counts = counts;
  park(slot);
  if (std::ranges::none_of(slot_, [&](const Slot& o) { return o.taken && o.team == team; })) team_[index(team)].clear();
}

void SparkArena::stand_at(std::size_t slot, double x_m, double y_m, double heading_rad) {
  plant::PitchPlace at{.x_m = x_m, .y_m = y_m, .heading_rad = heading_rad};
  const auto& rad = pitch_->truth(slot).joint_rad;
  at.joints_rad.assign(rad.begin(), rad.begin() + static_cast<std::ptrdiff_t>(body_.joints()));
  pitch_->place(slot, at);
  Slot& s = slot_[slot];
  s.mark_s = -1;
  s.down = false;
  s.v_before_mps = {};
}

void SparkArena::park(std::size_t slot) {
  stand_at(slot, kParkStep_m * (static_cast<double>(slot) - static_cast<double>(slot_.size() - 1) / 2), kParkY_m, 0);
}

void SparkArena::drive(std::size_t slot, std::size_t joint, double radps) {
  slot_[slot].speed_radps[joint] = std::clamp(radps, -kMostSpeed_radps, kMostSpeed_radps);
}

bool SparkArena::beam(std::size_t slot, double x_m, double y_m, double degrees) {
  if (!game_.may_beam()) return false;
  Slot& s = slot_[slot];
  ++s.counts.beams;
  if (options_.beam_noise) {
    x_m += kBeamNoise_m * s.random.uniform(-1, 1);
    y_m += kBeamNoise_m * s.random.uniform(-1, 1);
    degrees += kBeamNoise_deg * s.random.uniform(-1, 1);
  }
  // In its own half; beyond the side lines no farther than the ground reaches.
  x_m = std::clamp(x_m, -kSparkField.length_m / 2, 0.0);
  y_m = std::clamp(y_m, -kSparkField.width_m / 2, kSparkField.width_m / 2);
  const double side = s.team == Team::left ? 1 : -1;
  stand_at(slot, side * x_m, side * y_m, math::wrap_pi(degrees / kDegrees + (side < 0 ? math::kPi : 0)));
  return true;
}

void SparkArena::say(std::size_t slot, std::string_view text) { slot_[slot].saying = text.substr(0, kMostSaid); }

void SparkArena::put_ball(const Vec3& p_m, const Vec3& v_mps) {
  pitch_->place_ball(p_m, v_mps);
  game_.moved(p_m);
}

void SparkArena::put_player(std::size_t slot, double x_m, double y_m, double heading_rad) {
  stand_at(slot, x_m, y_m, heading_rad);
}

std::optional<std::size_t> SparkArena::find(Team team, std::uint32_t number) const {
  for (std::size_t i = 0; i < slot_.size(); ++i)
    if (slot_[i].taken && slot_[i].team == team && slot_[i].number == number) return i;
  return std::nullopt;
}

void SparkArena::count(Slot& s, const plant::BodyTruth& truth) {
  ++s.counts.cycles;
  if (!s.down && truth.fallen) ++s.counts.falls;
  if (truth.fallen || (s.down && (truth.tilt_rad > kUpright_rad || truth.body_down)))
    s.down = true;
  else
    s.down = false;
  const double now = now_s();
  if (s.mark_s >= 0 && now - s.mark_s < kMark_s) return;
  if (s.mark_s >= 0 && !s.down)
    s.counts.walked_m += math::hypot(truth.torso.p_m.x - s.mark_m.x, truth.torso.p_m.y - s.mark_m.y);
  s.mark_m = truth.torso.p_m;
  s.mark_s = now;
}

void SparkArena::step() {
  constexpr int kSteps = static_cast<int>(kCycleNs / plant::kPitchStepNs);
  for (int step = 0; step < kSteps; ++step) {
    for (std::size_t i = 0; i < slot_.size(); ++i) {
      Slot& s = slot_[i];
      for (std::size_t j = 0; j < kJoints; ++j) {
        const std::size_t joint = map_.joint(j);
        const kinematics::Link& link = body_.links[joint + 1];
        const double at = pitch_->truth(i).joint_rad[joint], speed = map_.sign(j) * s.speed_radps[j];
        const double wanted = s.target_rad[j] + speed * kStep_s;
        double& target = s.target_rad[j];
        target =
            std::clamp(std::clamp(wanted, at - kMostAhead_rad, at + kMostAhead_rad), link.least_rad, link.most_rad);
        plant::JointDrive drive;
        drive.mode = plant::DriveMode::velocity;
        drive.velocity_radps = speed + kHold_per_s * (target - at);
        pitch_->command(i, joint, drive);
      }
    }
    pitch_->step();
  }
  ++cycle_;
  for (std::size_t i = 0; i < slot_.size(); ++i) {
    Slot& s = slot_[i];
    const plant::BodyTruth& truth = pitch_->truth(i);
    s.accel_mps2 = truth.torso.q.conjugate().rotate((truth.v_world_mps - s.v_before_mps) / kCycle_s + Vec3{0, 0, 9.81});
    s.v_before_mps = truth.v_world_mps;
    s.said = std::move(s.saying);
    s.saying.clear();
    if (s.taken) count(s, truth);
  }
  const int by = pitch_->ball().touched_by;
  std::optional<Team> touched;
  if (by >= 0 && slot_[static_cast<std::size_t>(by)].taken) touched = slot_[static_cast<std::size_t>(by)].team;
  if (const auto put = game_.step(pitch_->ball().p_m, touched)) pitch_->place_ball(*put);
}

kinematics::Pose SparkArena::eye(std::size_t slot) const { return pitch_->truth(slot).link[eye_link_] * eye_in_link_; }

SeenPlayer SparkArena::seen(std::size_t slot) const {
  const plant::BodyTruth& truth = pitch_->truth(slot);
  SeenPlayer out{team_[index(slot_[slot].team)], slot_[slot].number, {}};
  const auto middle = [&](std::size_t joint) {  // of the link that this joint of SimSpark's moves
    const std::size_t link = map_.joint(joint) + 1;
    return truth.link[link].of(body_.links[link].com_m);
  };
  out.part_m = {middle(1), middle(5), middle(9), middle(15), middle(21)};
  return out;
}

void SparkArena::feel(std::size_t slot, SparkPercepts& out) const {
  const Slot& s = slot_[slot];
  const plant::BodyTruth& truth = pitch_->truth(slot);
  out.has_gyro = out.has_acceleration = true;
  out.gyro_dps = triple(to_spark(truth.gyro_radps) * kDegrees);
  out.acceleration_mps2 = triple(to_spark(s.accel_mps2));
  for (std::size_t j = 0; j < kJoints; ++j)
    out.joint[out.joints++] = {spark_joints()[j].perceptor, kDegrees * map_.sign(j) * truth.joint_rad[map_.joint(j)]};
  for (const std::size_t side : {std::size_t{1}, std::size_t{0}}) {  // the right foot first, as the server has it
    const auto& cell = pitch_->sensors(slot).cell_n[side];
    const double sum = cell[0] + cell[1] + cell[2] + cell[3];
    if (!sole_[side] || sum <= 0) continue;
    const Vec3& half = sole_[side]->half_m;
    const Vec3 at{half.x * (cell[0] + cell[1] - cell[2] - cell[3]) / sum,
                  half.y * (cell[0] + cell[2] - cell[1] - cell[3]) / sum, -half.z};
    out.force[out.forces++] = {side == 0 ? "lf" : "rf", triple(to_spark(at)), {0, 0, sum}};
  }
}

/// One message of each team in two cycles, and its own one.
void SparkArena::hear(std::size_t slot, SparkPercepts& out) {
  Slot& s = slot_[slot];
  const auto cycle = static_cast<int>(cycle_);
  const kinematics::Pose head = eye(slot);
  for (std::size_t i = 0; i < slot_.size() && out.hears < out.heard.size(); ++i) {
    const Slot& o = slot_[i];
    if (!o.taken || o.said.empty()) continue;
    wire::SparkHeard heard{game_.time_s(), team_[index(o.team)], o.said, i == slot, 0};
    if (i != slot) {
      int& before = s.heard_before[o.team == s.team ? 0 : 1];
      const Vec3 to = head.inverse().of(eye(i).p_m);
      if (cycle - before < kHearEvery || norm(to) > kHearing_m) continue;
      before = cycle;
      heard.direction_deg = kDegrees * math::atan2(to.y, to.x);
    }
    out.heard[out.hears++] = heard;
  }
}

void SparkArena::sense_nobody(SparkPercepts& out) const {
  out = {};
  out.now_s = now_s();
  out.has_game = true;
  out.left_goals = static_cast<std::uint32_t>(game_.score(Team::left));
  out.right_goals = static_cast<std::uint32_t>(game_.score(Team::right));
  out.game_s = game_.time_s();
  out.play_mode = to_string(game_.mode());
}

void SparkArena::sense(std::size_t slot, SparkPercepts& out) {
  sense_nobody(out);
  Slot& s = slot_[slot];
  if (!s.told) {
    out.number = s.number;
    out.side = to_string(s.team);
    s.told = true;
  }
  feel(slot, out);
  if (cycle_ % kSeeEvery == 0) {
    std::vector<SeenPlayer> players;
    for (std::size_t i = 0; i < slot_.size(); ++i)
      if (slot_[i].taken) players.push_back(seen(i));
    s.vision->see(eye(slot), pitch_->ball().p_m, players, s.random, out);
  }
  hear(slot, out);
}

}  // namespace sinew::simspark
