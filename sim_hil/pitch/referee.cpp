#include "sim_hil/pitch/referee.hpp"

#include <algorithm>
#include <cstdio>

namespace sinew::plant {
namespace {

using math::Vec3;

constexpr double kBeside_m = 0.5;          // from the touch line, where penalised robots wait
constexpr double kApart_m = 0.4;           // between those
constexpr double kClearOfRobots_m = 0.25;  // a ball is not put nearer to a robot
constexpr double kSpotStep_m = 0.1;
constexpr std::size_t kLogged = 1024;  // room from the start

std::int64_t ns_of(double seconds) { return static_cast<std::int64_t>(seconds * 1e9); }

}  // namespace

std::string_view to_string(GameState state) {
  constexpr std::string_view kNames[] = {"initial", "ready", "set", "playing", "finished"};
  return kNames[static_cast<std::size_t>(state)];
}

std::string_view to_string(Penalty penalty) {
  constexpr std::string_view kNames[] = {"none",    "illegal position", "incapable", "left the field",
                                         "pushing", "ball holding",     "picked up"};
  return kNames[static_cast<std::size_t>(penalty)];
}

Referee::Referee(const FieldSize& field, const BallSize& ball, const RefereeRules& rules,
                 std::span<const std::uint8_t> teams, std::uint8_t first_kick_off)
    : field_(field),
      ball_(ball),
      rules_(rules),
      robots_(std::min(teams.size(), kMostRobots)),
      first_kick_off_(first_kick_off % 2) {
  for (std::size_t i = 0; i < robots_; ++i) robot_[i].team = teams[i] % 2;
  log_.reserve(kLogged);
}

double Referee::seconds_left(std::int64_t now_ns) const {
  const double gone = half_began_ns_ < 0 ? 0 : static_cast<double>(now_ns - half_began_ns_) * 1e-9;
  return state_ == GameState::finished ? 0 : std::max(0.0, rules_.half_s - gone);
}

double Referee::penalty_seconds_left(std::size_t robot, std::int64_t now_ns) const {
  const Robot& r = robot_[robot];
  return r.penalty == Penalty::none ? 0 : std::max(0.0, static_cast<double>(r.penalty_end_ns - now_ns) * 1e-9);
}

void Referee::note(Decision::Kind kind, std::int64_t now_ns, int team, int robot) {
  Decision d;
  d.kind = kind, d.at_ns = now_ns, d.team = team, d.robot = robot, d.state = state_, d.score = score_;
  if (robot >= 0) d.penalty = robot_[static_cast<std::size_t>(robot)].penalty;
  log_.push_back(d);
}

void Referee::enter(GameState state, std::int64_t now_ns) {
  state_ = state;
  since_ns_ = now_ns;
  note(Decision::Kind::state, now_ns, -1);
}

void Referee::start(std::int64_t now_ns) {
  if (state_ == GameState::finished)
    ++half_;
  else if (state_ != GameState::initial)
    return;
  half_began_ns_ = -1;
  kick_off_team_ = half_ % 2 == 1 ? first_kick_off_ : 1 - first_kick_off_;
  enter(GameState::ready, now_ns);
}

void Referee::penalise(std::size_t robot, Penalty penalty, std::int64_t now_ns) {
  if (robot >= robots_ || penalty == Penalty::none || robot_[robot].penalty != Penalty::none) return;
  Robot& r = robot_[robot];
  r.penalty = penalty;
  r.penalty_end_ns = now_ns + ns_of(rules_.penalty_s);
  r.down_since_ns = -1;
  r.to_take_out = true;
  note(Decision::Kind::penalty, now_ns, r.team, static_cast<int>(robot));
}

void Referee::order_move(std::size_t robot, double x_m, double y_m, double heading_rad) {
  if (orders_.moves < orders_.move.size()) orders_.move[orders_.moves++] = {robot, x_m, y_m, heading_rad};
}

/// Penalised robots wait beside their own half and come back over the touch line.
void Referee::move_penalised(std::int64_t now_ns) {
  for (std::size_t i = 0; i < robots_; ++i) {
    Robot& r = robot_[i];
    if (r.penalty == Penalty::none) continue;
    const double own = side(r.team);
    const double line_y = r.team == 0 ? -field_.width_m / 2 : field_.width_m / 2;
    const double inwards = line_y < 0 ? math::kPi / 2 : -math::kPi / 2;
    const double x = own * std::max(0.5, field_.length_m / 2 - 0.5 - kApart_m * static_cast<double>(i));
    if (r.to_take_out) {
      r.to_take_out = false;
      order_move(i, x, line_y + (line_y < 0 ? -kBeside_m : kBeside_m), inwards);
    } else if (now_ns >= r.penalty_end_ns && (state_ == GameState::playing || state_ == GameState::ready)) {
      note(Decision::Kind::back, now_ns, r.team, static_cast<int>(i));
      r.penalty = Penalty::none;
      order_move(i, x, line_y, inwards);
    }
  }
}

Vec3 Referee::free_spot(Vec3 at, const Seen& seen) const {
  const auto taken = [&] {
    return std::any_of(seen.robots.begin(), seen.robots.end(),
                       [&](const SeenRobot& r) { return math::hypot(r.x_m - at.x, r.y_m - at.y) < kClearOfRobots_m; });
  };
  // Towards the middle line, then past it: 10 m are always enough.
  const double way = at.x > 0 ? -kSpotStep_m : kSpotStep_m;
  for (int i = 0; i < 100 && taken(); ++i) at.x += way;
  return at;
}

void Referee::restart(Decision::Kind kind, int team, Vec3 at, const Seen& seen, std::int64_t now_ns) {
  at = free_spot(at, seen);
  at.z = ball_.radius_m;
  orders_.ball = at;
  ball_given_m_ = at;
  kicking_team_ = team;
  kick_given_ns_ = now_ns;
  note(kind, now_ns, team);
}

/// At "set" everybody is in the own half, and the team that does not kick off is outside of the circle.
void Referee::judge_places(const Seen& seen, std::int64_t now_ns) {
  for (std::size_t i = 0; i < robots_; ++i) {
    const SeenRobot& r = seen.robots[i];
    const bool own_half = r.x_m * side(robot_[i].team) >= 0;
    const bool in_circle = math::hypot(r.x_m, r.y_m) < field_.circle_diameter_m / 2;
    const bool on_field = math::fabs(r.x_m) <= field_.length_m / 2 && math::fabs(r.y_m) <= field_.width_m / 2;
    if (!own_half || !on_field || (in_circle && robot_[i].team != kick_off_team_))
      penalise(i, Penalty::illegal_position, now_ns);
  }
}

void Referee::judge_robots(const Seen& seen, std::int64_t now_ns) {
  for (std::size_t i = 0; i < robots_; ++i) {
    Robot& r = robot_[i];
    if (r.penalty != Penalty::none) continue;
    const SeenRobot& at = seen.robots[i];
    if (!at.fallen)
      r.down_since_ns = -1;
    else if (r.down_since_ns < 0)
      r.down_since_ns = now_ns;
    else if (now_ns - r.down_since_ns >= ns_of(rules_.fallen_s))
      penalise(i, Penalty::incapable, now_ns);
    if (math::fabs(at.x_m) > field_.length_m / 2 + field_.border_m ||
        math::fabs(at.y_m) > field_.width_m / 2 + field_.border_m)
      penalise(i, Penalty::left_field, now_ns);
  }
}

void Referee::judge_ball(const Seen& seen, std::int64_t now_ns) {
  const Vec3& b = seen.ball_m;
  const auto toucher = static_cast<std::size_t>(seen.touched_by);
  const int touched = seen.touched_by >= 0 && toucher < robots_ ? robot_[toucher].team : -1;
  if (kicking_team_ >= 0) {
    const bool moved = math::hypot(b.x - ball_given_m_.x, b.y - ball_given_m_.y) > rules_.moved_m;
    if (moved && touched >= 0 && touched != kicking_team_) penalise(toucher, Penalty::illegal_position, now_ns);
    if (moved || now_ns - kick_given_ns_ >= ns_of(rules_.kick_off_s)) kicking_team_ = -1;
  }
  const double end = field_.length_m / 2, edge = field_.width_m / 2, r = ball_.radius_m;
  const double x_side = b.x > 0 ? 1 : -1, y_side = b.y > 0 ? 1 : -1;
  if (math::fabs(b.x) > end + r) {
    const int defends = side(0) == static_cast<int>(x_side) ? 0 : 1;
    if (math::fabs(b.y) < field_.goal_width_m / 2 && b.z < field_.goal_height_m) {
      ++score_[static_cast<std::size_t>(1 - defends)];
      note(Decision::Kind::goal, now_ns, 1 - defends, seen.touched_by >= 0 ? static_cast<int>(toucher) : -1);
      kick_off_team_ = defends;
      enter(GameState::ready, now_ns);
      orders_.ball = Vec3{0, 0, r};
    } else if (touched == defends) {
      restart(Decision::Kind::corner_kick, 1 - defends, {x_side * end, y_side * edge, 0}, seen, now_ns);
    } else {
      restart(Decision::Kind::goal_kick, defends,
              {x_side * (end - field_.goal_area_length_m), y_side * field_.goal_area_width_m / 2, 0}, seen, now_ns);
    }
  } else if (math::fabs(b.y) > edge + r) {
    restart(Decision::Kind::throw_in, touched >= 0 ? 1 - touched : kick_off_team_,
            {std::clamp(b.x, -end, end), y_side * edge, 0}, seen, now_ns);
  }
}

const Referee::Orders& Referee::step(const Seen& seen, std::int64_t now_ns) {
  orders_.ball.reset();
  orders_.moves = 0;
  if (seen.robots.size() < robots_) return orders_;
  const std::int64_t in_state_ns = now_ns - since_ns_;
  switch (state_) {
    case GameState::initial:
    case GameState::finished:
      break;
    case GameState::ready:
      judge_robots(seen, now_ns);
      if (in_state_ns < ns_of(rules_.ready_s)) break;
      enter(GameState::set, now_ns);
      judge_places(seen, now_ns);
      orders_.ball = Vec3{0, 0, ball_.radius_m};
      break;
    case GameState::set:
      if (in_state_ns < ns_of(rules_.set_s)) break;
      enter(GameState::playing, now_ns);
      if (half_began_ns_ < 0) half_began_ns_ = now_ns;
      kicking_team_ = kick_off_team_;
      kick_given_ns_ = now_ns;
      ball_given_m_ = {0, 0, ball_.radius_m};
      note(Decision::Kind::kick_off, now_ns, kick_off_team_);
      break;
    case GameState::playing:
      judge_robots(seen, now_ns);
      judge_ball(seen, now_ns);
      break;
  }
  if (half_began_ns_ >= 0 && state_ != GameState::finished && now_ns - half_began_ns_ >= ns_of(rules_.half_s))
    enter(GameState::finished, now_ns);
  move_penalised(now_ns);
  return orders_;
}

std::string to_string(const Referee::Decision& d) {
  char text[128];
  const auto said = [&](const char* format, auto... values) {
    std::snprintf(text, sizeof text, format, static_cast<double>(d.at_ns) * 1e-9, values...);
    return std::string(text);
  };
  using Kind = Referee::Decision::Kind;
  switch (d.kind) {
    case Kind::state:
      return said("%.1f s: %s", to_string(d.state).data());
    case Kind::kick_off:
      return said("%.1f s: kick-off for team %d", d.team);
    case Kind::goal:
      return said("%.1f s: goal for team %d, %d:%d", d.team, d.score[0], d.score[1]);
    case Kind::throw_in:
      return said("%.1f s: throw-in for team %d", d.team);
    case Kind::goal_kick:
      return said("%.1f s: goal kick for team %d", d.team);
    case Kind::corner_kick:
      return said("%.1f s: corner kick for team %d", d.team);
    case Kind::penalty:
      return said("%.1f s: robot %d: %s", d.robot, to_string(d.penalty).data());
    case Kind::back:
      return said("%.1f s: robot %d comes back", d.robot);
  }
  return {};
}

}  // namespace sinew::plant
