#include "sim_hil/simspark/session.hpp"

#include <algorithm>

#include "sim_hil/simspark/frame.hpp"

namespace sinew::simspark {
namespace {

using math::Vec3;
using wire::SparkEffector;
using wire::SparkOrder;

constexpr std::size_t kMostName = 32;
constexpr int kMonitorEvery = 2;     // cycles
constexpr double kMostMoved_m = 17;  // of what a monitor puts somewhere, from the middle

std::optional<Team> team_of(std::string_view side) {
  if (side == "Left" || side == "left") return Team::left;
  if (side == "Right" || side == "right") return Team::right;
  return std::nullopt;
}

bool on_ground(const Vec3& p) {
  return math::fabs(p.x) <= kMostMoved_m && math::fabs(p.y) <= kMostMoved_m && p.z >= -1 && p.z <= kMostMoved_m;
}

}  // namespace

void DoorCounts::tell(std::string line) {
  if (news.size() < kMostNews) news.push_back(std::move(line));
}

void DoorCounts::add_unknown(std::string_view type) {
  ++unknown;
  const std::string key(type.substr(0, kMostName));
  if (of_type.size() < kMostTypes || of_type.contains(key)) ++of_type[key];
}

Connection::Connection(SparkArena& arena, DoorCounts& counts, std::string address)
    : arena_(arena), counts_(counts), address_(std::move(address)), buffer_(kMostFrame), frames_(buffer_) {
  ++counts_.connections;
}

void Connection::close(std::string why) {
  if (closed()) return;
  why_ = std::move(why);
  ++counts_.closed;
  counts_.tell(name() + " at " + address_ + ": " + why_);
}

void Connection::receive(std::span<const std::byte> bytes) {
  for (const std::byte b : bytes) {
    if (closed()) return;
    const bool whole = frames_.push(static_cast<char>(b));
    if (frames_.dropped() > 0) return close("a message of more than 65536 bytes");
    if (!whole) continue;
    ++counts_.messages;
    obey(frames_.text());
  }
}

void Connection::drop_sent(std::size_t bytes) {
  sent_ += bytes;
  if (sent_ < out_.size()) return;
  out_.clear();
  sent_ = 0;
}

void Connection::send(std::span<const char> frame) {
  if (frame.empty() || waiting().size() + frame.size() > kMostWaiting) {
    ++counts_.unsent;
    return;
  }
  if (sent_ > 0) out_.erase(0, sent_), sent_ = 0;
  out_.append(frame.data(), frame.size());
  ++counts_.sent;
}

AgentSession::~AgentSession() {
  if (!slot_) return;
  const PlayerCounts& c = arena_.counts(*slot_);
  char figures[128];
  std::snprintf(figures, sizeof figures, ": left after %.2f s, walked %.2f m, %u falls, %u beams",
                kCycle_s * static_cast<double>(c.cycles), c.walked_m, c.falls, c.beams);
  counts_.tell(name() + figures);
  arena_.leave(*slot_);
}

std::string AgentSession::name() const {
  if (!slot_) return "agent";
  for (const Team team : {Team::left, Team::right})
    for (std::uint32_t n = 1; n <= kMostOfTeam; ++n)
      if (arena_.find(team, n) == slot_) return std::string(arena_.team_name(team)) + " " + std::to_string(n);
  return "agent";
}

void AgentSession::init(const SparkEffector& e) {
  if (slot_) return counts_.add_unknown("init, once more");
  std::string why;
  if (!scene_) why = "(init) before (scene)";
  if (e.name.size() > kMostName) why = "a team's name of more than 32 letters";
  if (why.empty()) slot_ = arena_.enter(e.name, e.number, why);
  if (!slot_) {
    ++counts_.refused;
    return close("refused: " + why);
  }
  ++counts_.agents;
  synced_ = true;  // the first cycle does not wait for it
  counts_.tell(name() + " at " + address_ + " plays");
}

void AgentSession::obey(std::string_view text) {
  using Kind = SparkEffector::Kind;
  wire::SparkEffectors in(text);
  SparkEffector e;
  while (!closed() && in.next(e)) {
    const bool early = !slot_ && (e.kind == Kind::joint || e.kind == Kind::beam || e.kind == Kind::say);
    if (early) {
      ++counts_.early;
      continue;
    }
    switch (e.kind) {
      case Kind::scene:
        if (scene_) {
          counts_.add_unknown("scene, once more");
          break;
        }
        scene_ = true;
        tell();
        break;
      case Kind::init:
        init(e);
        break;
      case Kind::joint:
        if (const auto joint = SparkJointMap::find_effector(e.name))
          arena_.drive(*slot_, *joint, e.value[0]);
        else
          counts_.add_unknown(e.name);
        break;
      case Kind::beam:
        if (!arena_.beam(*slot_, e.value[0], e.value[1], e.value[2])) ++counts_.not_now;
        break;
      case Kind::say:
        arena_.say(*slot_, e.name);
        break;
      case Kind::sync:
        synced_ = true;
        break;
      case Kind::pass:   // its play mode is not among ours
      case Kind::motor:  // the MuJoCo server's
      case Kind::other:
        counts_.add_unknown(e.kind == Kind::pass ? "pass" : e.name);
        break;
    }
  }
  if (in.error() != wire::SparkError::none)
    close("no message of an agent (" + std::string(to_string(in.error())) + "): " + std::string(text.substr(0, 60)));
}

void AgentSession::tell() {
  if (closed() || !scene_) return;
  synced_ = false;
  if (slot_)
    arena_.sense(*slot_, percepts_);
  else
    arena_.sense_nobody(percepts_);
  static thread_local std::array<char, 32768> buffer;
  send(wire::SparkWriter(buffer).percepts(percepts_).frame());
}

void MonitorSession::obey(std::string_view text) {
  wire::SparkOrders in(text);
  SparkOrder order;
  while (in.next(order)) obey(order);
  if (in.error() != wire::SparkError::none)
    close("no message of a monitor (" + std::string(to_string(in.error())) + "): " + std::string(text.substr(0, 60)));
}

void MonitorSession::obey(const SparkOrder& o) {
  using Kind = SparkOrder::Kind;
  SparkGame& game = arena_.game();
  const std::optional<Team> team = team_of(o.name);
  const plant::BallTruth& ball = arena_.pitch().ball();
  const auto useless = [&] { counts_.add_unknown("order without sense"); };
  switch (o.kind) {
    case Kind::kick_off:
      if (!team) return useless();
      game.kick_off(*team);
      arena_.put_ball({}, {});
      return;
    case Kind::play_mode:
      if (const auto mode = play_mode_of(o.name)) return game.set_mode(*mode, ball.p_m);
      return useless();
    case Kind::ball: {
      const Vec3 at = o.has_position ? Vec3{o.position[0], o.position[1], o.position[2]} : ball.p_m;
      const Vec3 v{o.velocity[0], o.velocity[1], o.velocity[2]};
      constexpr double kMost_mps = 50;
      if (!on_ground(at) || norm(v) > kMost_mps) return useless();
      return arena_.put_ball(at, v);
    }
    case Kind::player:
    case Kind::kill_player: {
      const auto slot = team ? arena_.find(*team, o.number) : std::nullopt;
      if (!slot) return useless();
      if (o.kind == Kind::kill_player) return killed_.push_back(*slot);
      if (!o.has_position || !on_ground({o.position[0], o.position[1], o.position[2]})) return useless();
      const math::Vec3 ahead = arena_.pitch().truth(*slot).torso.q.rotate({1, 0, 0});
      const double heading =
          o.has_degrees ? math::wrap_pi(o.degrees / kDegrees + math::kPi / 2) : math::atan2(ahead.y, ahead.x);
      return arena_.put_player(*slot, o.position[0], o.position[1], heading);
    }
    case Kind::time:
      if (o.value[0] < 0) return useless();
      return game.set_time(o.value[0]);
    case Kind::score:
      return game.set_score(static_cast<int>(o.value[0]), static_cast<int>(o.value[1]));
    case Kind::drop_ball:
      return game.set_mode(PlayMode::play_on, ball.p_m);
    case Kind::kill_server:
      kills_ = true;
      return;
    case Kind::request_state:
      told_ = false;
      return;
    case Kind::other:
      return counts_.add_unknown(o.name);
  }
}

void MonitorSession::tell() {
  if (closed() || cycles_++ % kMonitorEvery != 0) return;
  std::array<char, 2048> buffer;
  wire::SparkWriter out(buffer);
  const auto value = [&](std::string_view name, double number, int decimals = 2) {
    out.open(name).number(number, decimals).close();
  };
  const SparkGame& game = arena_.game();
  out.open("");
  if (!told_) {
    value("FieldLength", kSparkField.length_m);
    value("FieldWidth", kSparkField.width_m);
    value("GoalWidth", kSparkField.goal_width_m);
    value("GoalDepth", kSparkField.goal_depth_m);
    value("GoalHeight", kSparkField.goal_height_m);
    value("FreeKickDistance", kSparkField.circle_diameter_m / 2);
    value("BallRadius", kSparkBall.radius_m, 3);
    value("BallMass", kSparkBall.mass_kg, 3);
    out.open("play_modes");
    for (std::size_t i = 0; i < kPlayModes; ++i) out.word(to_string(static_cast<PlayMode>(i)));
    out.close();
    told_ = true;
  }
  value("time", game.time_s());
  value("half", game.half(), 0);
  value("score_left", game.score(Team::left), 0);
  value("score_right", game.score(Team::right), 0);
  value("play_mode", static_cast<double>(game.mode()), 0);
  for (const Team team : {Team::left, Team::right})
    if (const auto name = arena_.team_name(team); !name.empty())
      out.open(team == Team::left ? "team_left" : "team_right").word(name).close();
  out.close();
  send(out.frame());
}

}  // namespace sinew::simspark
