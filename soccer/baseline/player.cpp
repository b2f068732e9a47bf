#include "soccer/baseline/player.hpp"

#include <algorithm>

#include "math/elementary.hpp"
#include "soccer/field.hpp"

namespace sinew::soccer {

using namespace std::chrono_literals;
using msg::GamePhase;

namespace {

// Frozen: docs/decisions/0040-the-baseline-is-frozen-and-small.md.
constexpr double kForward_mps = 0.3, kAside_mps = 0.15, kTurn_radps = 1, kSearch_radps = 0.5, kPer_s = 1.2;
constexpr double kTurnsTo_m = 0.5;    // a place that is farther away it turns to, and walks ahead
constexpr double kBallOld_s = 4;      // a ball not seen for so long is searched
constexpr double kKeepBall_m = 0.25;  // on the way round it
constexpr double kKeepRobot_m = 0.2;  // from another robot's edge
constexpr double kBehind_m = 0.12;    // the place where it kicks: there it stops to go round the ball
constexpr double kNear_m = 0.02, kNear_rad = 0.12;
constexpr double kKickAtMost_s = 6, kFollow_mps = 0.1, kFollow_s = 0.8;
constexpr double kBallMoved_m = 0.15, kClear_m = 1;  // the others' kick-off
constexpr double kSweep_rad = 1.2, kSweep_s = 3, kDown_rad = 0.35;
constexpr double kGlance_s = 0.9, kGlanceEach_s = 2.6, kGlanceFrom_m = 0.6, kBallHeight_m = 0.07;

/// The direction `way`, or past `thing` where that is in between.
double past(double way, double far_m, const FieldPoint& thing, double keep_m) {
  const double m = length_m(thing);
  if (m - keep_m >= far_m) return way;
  const double half = m <= keep_m ? 0.5 * math::kPi : math::asin(keep_m / m);
  const double off = math::wrap_pi(way - bearing_rad(thing));
  if (math::fabs(off) >= half) return way;
  return math::wrap_pi(bearing_rad(thing) + math::copysign(half, off));
}

/// From side to side, near and far in turn; or at the ball, and away from a far one at times: where am I?
void gaze_at(bool sees_ball, const FieldPoint& ball, double now_s, msg::GazeCommand& gaze) {
  gaze.frame = msg::GazeFrame::robot;
  if (sees_ball && (length_m(ball) < kGlanceFrom_m || math::fmod(now_s, kGlanceEach_s) > kGlance_s)) {
    gaze.aim = msg::GazeAim::point;
    gaze.to = {ball.x_m, ball.y_m, kBallHeight_m};
    return;
  }
  const double turn = math::fmod(now_s, 2 * kSweep_s) / kSweep_s;  // 0 to 2
  const math::SinCos yaw = math::sincos(kSweep_rad * (2 * (turn < 1 ? turn : 2 - turn) - 1));
  const math::SinCos down = math::sincos((turn < 1 ? 0.7 : 1.8) * kDown_rad);
  gaze.aim = msg::GazeAim::direction;
  gaze.to = {down.cos * yaw.cos, down.cos * yaw.sin, -down.sin};
}

}  // namespace

void PlayBaseline::declare(rt::Declaration& d) {
  d.in("field", pose_, {.max_age = 1s, .optional = true});
  d.in("ball", ball_, {.max_age = 1s, .optional = true});
  d.in("obstacles", obstacles_, {.max_age = 1s, .optional = true});
  d.in("gait", gait_, {.max_age = 500ms});
  d.in("referee", referee_, {.max_age = 3s, .optional = true});
  d.in("safety", safety_, {.optional = true, .supervises = true});
  d.out("velocity", velocity_);
  d.out("kick", kick_);
  d.out("gaze", gaze_);
  d.state(doing_, since_, foot_, ball_at_set_, asked_);
  d.param("player", player_, {.min = 1, .max = 11, .doc = "its number in the team, for its place before a kick-off"});
  d.param("kick_x_m", kick_x_m_,
          {.unit = "m",
           .min = 0,
           .max = 0.5,
           .doc = "where the ball has to lie for a kick forward with the left foot within a step: ahead"});
  d.param("kick_y_m", kick_y_m_, {.unit = "m", .min = -0.2, .max = 0.5, .doc = "and to the left"});
}

void PlayBaseline::reset() {
  doing_ = Doing::stand;
  since_ = {};
  foot_ = msg::Foot::left;
  ball_at_set_ = {0, 0};
  asked_ = 0;
}

void PlayBaseline::become(Doing next, rt::Time now) {
  doing_ = next;
  since_ = now;
}

PlayBaseline::Seen PlayBaseline::look_around(rt::Time now) const {
  Seen s;
  if (const msg::FieldPose* pose = pose_.fresh(now)) {
    s.self = {pose->x_m, pose->y_m, pose->heading_rad};
    s.found = pose->found != 0;
  }
  const msg::BallModel* ball = ball_.fresh(now);
  if (ball && ball->seen.ns > 0) {
    s.ball = {ball->x_m, ball->y_m};
    s.sees_ball = ball->gone == 0 && msg::seconds(now - ball->seen) < kBallOld_s;
  }
  if (const msg::ObstacleModel* seen = obstacles_.fresh(now))
    for (std::uint32_t i = 0; i < seen->obstacles; ++i) {
      const msg::Obstacle& o = seen->obstacle[i];
      const FieldPoint at{o.x_m, o.y_m};
      if (s.has_nearest && length_m(at) >= length_m(s.nearest)) continue;
      s.has_nearest = true, s.nearest = at, s.nearest_radius_m = o.radius_m;
    }
  return s;
}

FieldAt PlayBaseline::ready_place(bool own_kick_off) const {
  const FieldSize& size = field_.size();
  if (player_ == 2) return {own_kick_off ? -0.45 : -size.circle_radius_m - 0.45, 0, 0};
  const double side = player_ == 3 ? -1 : 1;
  return {-0.25 * size.length_m, side * (player_ == 1 ? 0.1 : 0.25) * size.width_m, 0};
}

FieldAt PlayBaseline::place_for_kick(const Seen& seen, double behind_m) const {
  const FieldPoint ball = seen.self.out(seen.ball.x_m, seen.ball.y_m), goal{0.5 * field_.size().length_m, 0};
  const double aim = bearing_rad(goal - ball);
  const double side = foot_ == msg::Foot::left ? 1 : -1;
  const FieldPoint to_ball = FieldAt{0, 0, aim}.out(kick_x_m_ + behind_m, side * kick_y_m_);
  return {ball.x_m - to_ball.x_m, ball.y_m - to_ball.y_m, aim};
}

PlayBaseline::Speed PlayBaseline::go_to(const FieldAt& place, const Seen& seen, bool round_ball) const {
  const FieldAt to = seen.self.way_to(place);
  const double far_m = math::hypot(to.x_m, to.y_m);
  double way = far_m > 0 ? math::atan2(to.y_m, to.x_m) : 0;
  if (round_ball && seen.sees_ball) way = past(way, far_m, seen.ball, kKeepBall_m);
  if (seen.has_nearest) way = past(way, far_m, seen.nearest, seen.nearest_radius_m + kKeepRobot_m);
  const auto turn = [](double by_rad) { return std::clamp(kPer_s * by_rad, -kTurn_radps, kTurn_radps); };
  if (far_m > kTurnsTo_m) {
    const double ahead = std::max(0.0, math::cos(way));
    return {kForward_mps * ahead * ahead, 0, turn(way)};
  }
  const math::SinCos t = math::sincos(way);
  const double along = t.cos / (t.cos < 0 ? kAside_mps : kForward_mps), across = t.sin / kAside_mps;
  const double mps = std::min(kPer_s * far_m, 1 / math::hypot(along, across));
  return {mps * t.cos, mps * t.sin, turn(to.heading_rad)};
}

bool PlayBaseline::others_kick(const Seen& seen, const msg::RefereeState* said) const {
  if (!said || said->kick != msg::GameKick::other) return false;
  return !seen.sees_ball || length_m(seen.self.out(seen.ball.x_m, seen.ball.y_m) - ball_at_set_) < kBallMoved_m;
}

PlayBaseline::Speed PlayBaseline::play(const Seen& seen, const msg::GaitState& gait, rt::Time now) {
  const double here_s = msg::seconds(now - since_);
  if (doing_ == Doing::kick) {
    const bool answered =
        here_s > 0.2 && gait.request == asked_ &&
        (gait.progress == msg::RequestProgress::done || gait.progress == msg::RequestProgress::broken_off);
    if (answered || gait.refused == asked_ || here_s > kKickAtMost_s) become(Doing::follow, now);
    return {};
  }
  if (doing_ == Doing::follow) {
    if (here_s > kFollow_s) become(Doing::search, now);
    return {kFollow_mps, 0, 0};
  }
  if (!seen.sees_ball || !seen.found) {
    if (doing_ != Doing::search) become(Doing::search, now);
    // Once round on the spot, then as long to the middle of the field.
    const double round_s = 2 * math::kPi / kSearch_radps;
    if (seen.found && math::fmod(here_s, 2 * round_s) > round_s) {
      const FieldPoint middle = seen.self.in(0, 0);
      if (length_m(middle) > kTurnsTo_m)
        return go_to({0, 0, bearing_rad(FieldPoint{-seen.self.x_m, -seen.self.y_m})}, seen, false);
    }
    return {0, 0, seen.ball.y_m < 0 ? -kSearch_radps : kSearch_radps};
  }
  if (doing_ != Doing::approach && doing_ != Doing::align) {
    become(Doing::approach, now);
    foot_ = msg::Foot::left;
    const double left_m = distance_m(seen.self, place_for_kick(seen, 0));
    foot_ = msg::Foot::right;
    if (left_m < distance_m(seen.self, place_for_kick(seen, 0))) foot_ = msg::Foot::left;
  }
  const FieldAt place = place_for_kick(seen, 0), behind = place_for_kick(seen, kBehind_m);
  const auto within = [&](const FieldAt& at, double m, double rad) {
    return distance_m(seen.self, at) < m && turn_between_rad(seen.self, at) < rad;
  };
  if (doing_ == Doing::approach) {
    if (!within(behind, 0.1, 0.3)) return go_to(behind, seen, true);
    become(Doing::align, now);
  }
  if (!within(place, 0.3, 0.8)) {
    become(Doing::approach, now);
    return go_to(behind, seen, true);
  }
  if (!within(place, kNear_m, kNear_rad)) return go_to(place, seen, false);
  become(Doing::kick, now);
  msg::KickRequest& kick = kick_.loan();
  kick = {};
  kick.stamp = gait.stamp;
  kick.id = ++asked_;
  kick.motion = msg::BallMotion::kick_forward;
  kick.foot = foot_;
  kick.in_walk = 1;
  return {};
}

rt::StepStatus PlayBaseline::step(const rt::Step& step) noexcept {
  const msg::GaitState* gait = gait_.fresh(step.now);
  if (!gait) return rt::StepStatus::stale;
  const msg::RefereeState* said = referee_.fresh(step.now);
  const msg::SafetyState* safety = safety_.get();
  const Seen seen = look_around(step.now);
  const GamePhase phase = said ? said->phase : GamePhase::playing;
  const bool out = (said && said->penalty != msg::GamePenalty::none) || !msg::on_its_feet(gait->mode) ||
                   (safety && safety->action != msg::FailsafeAction::none);
  if (phase == GamePhase::set && seen.sees_ball) ball_at_set_ = seen.self.out(seen.ball.x_m, seen.ball.y_m);

  Speed speed;
  if (!out && phase == GamePhase::playing && !others_kick(seen, said)) {
    speed = play(seen, *gait, step.now);
  } else {
    if (doing_ != Doing::stand) become(Doing::stand, step.now);
    if (!out && phase == GamePhase::ready) {
      speed = {0, 0, kSearch_radps};
      if (seen.found) speed = go_to(ready_place(said->kick == msg::GameKick::own), seen, true);
    } else if (!out && phase == GamePhase::playing && seen.sees_ball && length_m(seen.ball) < kClear_m) {
      speed.forward_mps = seen.ball.x_m > 0 ? -kAside_mps : kForward_mps;  // away from the others' kick
    }
  }

  msg::GazeCommand& gaze = gaze_.loan();
  gaze = {};
  gaze.stamp = gait->stamp;
  gaze_at(seen.sees_ball, seen.ball, msg::seconds(step.now), gaze);
  msg::VelocityCommand& velocity = velocity_.loan();
  velocity = {};
  velocity.stamp = gait->stamp;
  velocity.linear_mps = {speed.forward_mps, speed.left_mps, 0};
  velocity.angular_radps = {0, 0, speed.turn_radps};
  return rt::StepStatus::ok;
}

}  // namespace sinew::soccer
