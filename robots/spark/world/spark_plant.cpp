#include "robots/spark/world/spark_plant.hpp"

#include <algorithm>
#include <chrono>

#include "motion/tilt.hpp"
#include "robots/kid/world/walk_score.hpp"
#include "sim_hil/simspark/agent.hpp"
#include "sim_hil/simspark/frame.hpp"
#include "sim_hil/worlds/json_object.hpp"

namespace sinew::plant {
namespace {

using math::Vec3;
using simspark::SparkAgent;

constexpr hal::Duration kPatience = std::chrono::seconds(20);  // of a server that waits for other agents, too
constexpr int kSendAt = 16;                                    // plant steps after the percepts: 4 ms
constexpr double kTakeOver_s = 1.5;  // these motors are stiff: what takes them over reaches its targets in this time
constexpr double kEyeHeight_m = 0.47, kFallenCosine = 0.5;
constexpr double kFootLoad_n = 2;
constexpr std::size_t kMostFrame = 65536;

/// Frames of the server, one after the other.
class SparkLine {
 public:
  explicit SparkLine(std::unique_ptr<hal::Stream> stream)
      : stream_(std::move(stream)), buffer_(kMostFrame), frames_(buffer_) {
    stream_->set_patience(kPatience);
  }
  hal::Status send(std::span<const char> frame) { return stream_->write(std::as_bytes(frame)); }
  /// The next message, at the latest after the patience.
  hal::Result<std::string_view> receive() {
    for (;;) {
      while (at_ < end_)
        if (frames_.push(static_cast<char>(bytes_[at_++]))) return frames_.text();
      if (frames_.dropped() > 0) return hal::Error{hal::Errc::bad_data, "a message of more than 65536 bytes"};
      const auto n = stream_->read(bytes_);
      if (!n) return n.error();
      at_ = 0, end_ = *n;
    }
  }

 private:
  std::unique_ptr<hal::Stream> stream_;
  std::vector<char> buffer_;
  wire::SparkFrames frames_;
  std::array<std::byte, 16384> bytes_{};
  std::size_t at_ = 0, end_ = 0;
};

}  // namespace

struct SparkPlant::Impl {
  Impl(std::shared_ptr<const kinematics::Body> body_, const simspark::SparkJointMap& map, SparkLine line_)
      : body(std::move(body_)), limbs(kinematics::Limbs::of(*body)), agent(map, *body), line(std::move(line_)) {
    targets.fill(math::kNan);
  }

  /// Waits for a message and takes it.
  hal::Status take() {
    const auto text = line.receive();
    if (!text) return text.error();
    if (const auto error = agent.take(*text); error != wire::SparkError::none)
      return hal::Error{hal::Errc::bad_data, "percepts", static_cast<std::int64_t>(error)};
    return {};
  }
  /// One cycle of the server.
  hal::Status cycle(std::span<const char> frame) {
    if (const hal::Status sent = line.send(frame); !sent) return sent;
    const double before = agent.felt().now_s;
    const hal::Status taken = take();
    const double passed = agent.felt().now_s - before;
    if (taken && passed > 1.5 * simspark::kCycle_s) ++missed;
    return taken;
  }
  std::span<const char> command() {
    std::array<double, kMostJoints> now = targets;
    if (!driven()) {
      driven_s = 0;
      std::copy_n(agent.felt().joints_rad.begin(), now.size(), from_rad.begin());
    } else if (driven_s < kTakeOver_s) {
      driven_s += simspark::kCycle_s;
      const double share = std::min(1.0, driven_s / kTakeOver_s);
      for (std::size_t i = 0; i < now.size(); ++i) now[i] = from_rad[i] + share * (targets[i] - from_rad[i]);
    }
    writer = wire::SparkWriter(out);
    return agent.command(std::span(now).first(body->joints()), writer).sync().frame();
  }
  hal::Status enter(const WorldChoice& choice, const std::string& team);
  void lose(const hal::Error& error) {
    if (lost.empty()) lost = std::string("the server is gone: ") + hal::to_string(error.code) + ", " + error.where;
  }
  void look();
  void sample();
  void sample_limb(std::size_t limb);
  void hear_referee();
  bool driven() const {
    return std::ranges::any_of(targets, [](double t) { return math::is_finite(t); });
  }

  std::shared_ptr<const kinematics::Body> body;
  kinematics::Limbs limbs;
  SparkAgent agent;
  SparkLine line;
  std::array<char, 4096> out{};
  wire::SparkWriter writer{out};
  std::array<double, kMostJoints> targets{}, from_rad{};
  double driven_s = 0;
  std::int64_t steps = 0;
  std::uint64_t missed = 0;
  std::string lost;
  Due due{};
  motion::Tilt tilt;
  BodyTruth felt{};  // what can be said of the body by its sensors
  std::optional<Vec3> place{};
  WalkScore score;
};

hal::Status SparkPlant::Impl::enter(const WorldChoice& choice, const std::string& team) {
  const auto value = [&](const char* key) { return choice.type->info.value(choice.values, key).value(); };
  const auto number = static_cast<std::uint32_t>(value("number"));
  const std::string scene = "rsg/agent/nao/nao_hetero.rsg " + std::to_string(static_cast<int>(value("robot_type")));
  if (const auto sent = line.send(wire::SparkWriter(out).scene(scene).frame()); !sent) return sent;
  if (const auto taken = take(); !taken) return taken;
  if (const auto sent = line.send(wire::SparkWriter(out).init(number, team).frame()); !sent) return sent;
  constexpr int kMostWait = 200;  // messages until it has a body and a side
  for (int i = 0; agent.felt().cycles == 0 || agent.said().side.empty(); ++i) {
    if (i == kMostWait) return hal::Error{hal::Errc::timeout, "a side of the field"};
    if (const auto taken = take(); !taken) return taken;
    if (agent.felt().cycles == 0 || agent.said().side.empty())
      if (const auto sent = line.send(wire::SparkWriter(out).sync().frame()); !sent) return sent;
  }
  wire::SparkWriter beam(out);
  beam.beam(value("beam_x_m"), value("beam_y_m"), value("beam_heading_deg")).sync();
  if (const auto done = cycle(beam.frame()); !done) return done;
  for (double s = 0; s < value("settle_s"); s += simspark::kCycle_s)
    if (const auto done = cycle(command()); !done) return done;
  missed = 0;
  tilt.start(agent.felt().accel_mps2);
  place = Vec3{value("beam_x_m"), value("beam_y_m"), 0};
  if (agent.said().side == "right") place = -*place;
  look();
  sample();
  return {};
}

/// What its sensors say of the body, for the report.
void SparkPlant::Impl::look() {
  const simspark::Felt& f = agent.felt();
  tilt.step(f.gyro_radps, f.accel_mps2, !driven(), simspark::kCycle_s);
  if (const auto found = place_of(agent.sights(), kEyeHeight_m, *place); found && agent.sights().at_s == f.now_s)
    place = found;
  felt.torso = {{place->x, place->y, 0}, tilt.q_world_torso()};
  felt.gyro_radps = tilt.rate_radps();
  const double up = tilt.up().z;
  felt.tilt_rad = math::acos(std::clamp(up, -1.0, 1.0));
  felt.fallen = up < kFallenCosine;
  for (std::size_t side = 0; side < 2; ++side) {
    felt.foot_n[side] = 0;
    for (const double n : f.cell_n[side]) felt.foot_n[side] += n;
  }
  felt.body_down = felt.fallen && felt.foot_n[0] < kFootLoad_n && felt.foot_n[1] < kFootLoad_n;
}

void SparkPlant::Impl::sample_limb(std::size_t limb) {
  msg::JointState& s = due.joints_samples[limb];
  s = {};
  s.stamp = {steps * kStepNs};
  s.count = kKidLimbJoints[limb];
  for (std::size_t i = 0; i < s.count; ++i) {
    s.effort_nm[i] = s.temperature_c[i] = s.voltage_v[i] = math::kNan;
    if (i >= limbs.joints[limb].size()) {
      s.position_rad[i] = s.velocity_radps[i] = math::kNan;
      continue;
    }
    const std::size_t joint = limbs.joints[limb][i];
    s.measured[i] = s.stamp;
    s.position_rad[i] = agent.felt().joints_rad[joint];
    s.velocity_radps[i] = agent.felt().joints_radps[joint];
    const bool on = math::is_finite(targets[joint]);
    s.mode[i] = on ? msg::JointMode::enabled : msg::JointMode::disabled;
    s.ready |= (on ? 1u : 0u) << i;
  }
}

void SparkPlant::Impl::hear_referee() {
  using simspark::PlayMode;
  const SparkAgent::Said& said = agent.said();
  const bool left = said.side != "right";
  msg::RefereeState& r = due.referee_sample;
  r = {};
  r.stamp = {steps * kStepNs};
  const auto mode = simspark::play_mode_of(said.play_mode);
  const bool over = mode == PlayMode::game_over;
  const bool waits = mode == PlayMode::before_kick_off || mode == PlayMode::goal_left || mode == PlayMode::goal_right;
  r.phase = over ? msg::GamePhase::finished : (waits ? msg::GamePhase::ready : msg::GamePhase::playing);
  constexpr PlayMode kOfLeft[] = {PlayMode::kick_off_left, PlayMode::kick_in_left, PlayMode::corner_kick_left,
                                  PlayMode::goal_kick_left, PlayMode::free_kick_left};
  for (const PlayMode given : kOfLeft) {
    if (mode == given) r.kick = left ? msg::GameKick::own : msg::GameKick::other;
    if (mode == static_cast<PlayMode>(static_cast<int>(given) + 1))
      r.kick = left ? msg::GameKick::other : msg::GameKick::own;
  }
  constexpr double kHalf_s = 300;
  r.half = said.game_s < kHalf_s ? 1 : 2;
  r.left_s = std::max(0.0, kHalf_s * r.half - said.game_s);
  r.own_goals = static_cast<std::uint32_t>(left ? said.left_goals : said.right_goals);
  r.other_goals = static_cast<std::uint32_t>(left ? said.right_goals : said.left_goals);
  r.team = left ? 0 : 1;
  r.attacks_right = left ? 1 : 0;
}

void SparkPlant::Impl::sample() {
  const simspark::Felt& f = agent.felt();
  due.imu = due.soles = due.joints = due.referee = due.truth = true;
  due.imu_sample = {{steps * kStepNs}, f.gyro_radps.to<msg::Vec3>(), f.accel_mps2.to<msg::Vec3>()};
  due.soles_sample.stamp = {steps * kStepNs};
  for (std::size_t i = 0; i < msg::kSoleCells; ++i) due.soles_sample.force_n[i] = f.cell_n[i / 4][i % 4];
  for (std::size_t limb = 0; limb < kinematics::kLimbs; ++limb) sample_limb(limb);
  hear_referee();
  score.look(felt, driven(), 1e-9 * static_cast<double>(steps * kStepNs));
}

SparkPlant::SparkPlant(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
SparkPlant::~SparkPlant() = default;

WorldInfo SparkPlant::info() {
  WorldInfo info{"simspark", kSparkDevices, spark_options()};
  info.has_bodies = true;
  return info;
}

hal::Result<std::unique_ptr<SparkPlant>> SparkPlant::create(const WorldChoice& choice, const SparkServer& server,
                                                            std::string& why) {
  const kinematics::Body* const body = choice.body_of(0);
  why = "no body";
  if (!body) return hal::Error{hal::Errc::bad_argument, "simspark: a body"};
  const auto map = simspark::SparkJointMap::of(*body, why);
  if (!map) return hal::Error{hal::Errc::bad_argument, "simspark: a body of the class of Nao"};
  why = "no server answers there";
  auto stream = server.connect();
  if (!stream) return stream.error();
  auto impl =
      std::make_unique<Impl>(std::make_shared<const kinematics::Body>(*body), *map, SparkLine(std::move(*stream)));
  why = "the server did not let it play";
  if (const hal::Status entered = impl->enter(choice, server.team); !entered) return entered.error();
  return std::unique_ptr<SparkPlant>(new SparkPlant(std::move(impl)));
}

void SparkPlant::advance(std::span<const RobotCommand> commands) {
  Impl& w = *impl_;
  w.due.imu = w.due.soles = w.due.joints = w.due.referee = w.due.truth = false;
  ++w.steps;
  const std::int64_t in_cycle = w.steps % kSparkSteps;
  if (in_cycle == kSendAt && w.lost.empty()) {
    const RobotCommand& command = commands[0];
    std::size_t channel = 0;
    for (std::size_t limb = 0; limb < kinematics::kLimbs; ++limb)
      for (std::size_t i = 0; i < kKidLimbJoints[limb]; ++i, ++channel)
        if (i < w.limbs.joints[limb].size())
          w.targets[w.limbs.joints[limb][i]] = channel < command.size() ? command[channel] : math::kNan;
    if (const hal::Status done = w.cycle(w.command()); !done) w.lose(done.error());
  }
  if (in_cycle != 0 || !w.lost.empty()) return;
  w.look();
  w.sample();
}

msg::Time SparkPlant::now() const { return {impl_->steps * kStepNs}; }
const Due& SparkPlant::due() const { return impl_->due; }

WorldTruth SparkPlant::ground_truth() const {
  const BodyTruth& felt = impl_->felt;
  WorldTruth t;
  t.p_world_m = felt.torso.p_m.to<msg::Vec3>();
  t.q_world_base = felt.torso.q.to<msg::Quat>();
  t.gyro_radps = felt.gyro_radps.to<msg::Vec3>();
  t.contact = felt.body_down;
  t.landed = felt.foot_n[0] > 0 && felt.foot_n[1] > 0;
  return t;
}

Scene SparkPlant::scene(std::size_t /*camera*/) const { return {}; }
bool SparkPlant::still() const { return !impl_->lost.empty() || !impl_->driven(); }
std::uint32_t SparkPlant::news() const { return impl_->score.falls() + (impl_->lost.empty() ? 0 : 1); }

void SparkPlant::add_to(JsonObject& j) const {
  const Impl& w = *impl_;
  w.score.add_to(j);
  j.number("x_m", w.felt.torso.p_m.x);
  j.number("y_m", w.felt.torso.p_m.y);
  j.boolean("fallen", w.felt.fallen);
  j.text("play_mode", w.agent.said().play_mode);
  j.text("side", w.agent.said().side);
  j.integer("number", w.agent.said().number);
  j.integer("goals_left", static_cast<std::uint64_t>(w.agent.said().left_goals));
  j.integer("goals_right", static_cast<std::uint64_t>(w.agent.said().right_goals));
  j.number("server_s", w.agent.felt().now_s);
  j.integer("cycles_missed", w.missed);
  j.boolean("at_rest", still());
  j.boolean("motors_stopped", !w.driven());
  if (!w.lost.empty()) j.text("lost", w.lost);
}

Verdict SparkPlant::verdict() const {
  Verdict v = impl_->score.verdict(impl_->felt, false);
  if (impl_->lost.empty()) return v;
  v.good = false;
  v.outcome = impl_->lost;
  return v;
}
std::string SparkPlant::outcome() const {
  return impl_->lost.empty() ? impl_->score.text(impl_->felt, false) : impl_->lost;
}

}  // namespace sinew::plant
