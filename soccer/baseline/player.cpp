#include "soccer/baseline/player.hpp"

#include <algorithm>

namespace sinew::soccer::baseline {

using namespace std::chrono_literals;
using msg::BallMotion;

namespace {

// Places of PlayOptions::kicks.kinds.
enum Kinds : std::size_t { kForward, kOutward, kStepForward, kStepOutward };

double age_s(rt::Time then, rt::Time now) { return then.ns > 0 ? msg::seconds(now - then) : math::kInf; }

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
  d.out("state", state_);
  d.out("plan", plan_);
  d.state(progress_, chosen_, ball_before_, asked_);
  d.param("player", player_, {.min = 1, .max = 11, .doc = "its number in the team, for its place before a kick-off"});
  WalkLimits& w = options_.walk;
  d.param("forward_mps", w.forward_mps, {.unit = "m/s", .min = 0.02, .max = 2, .doc = "at most"});
  d.param("back_mps", w.back_mps, {.unit = "m/s", .min = 0.02, .max = 2, .doc = "at most"});
  d.param("side_mps", w.side_mps, {.unit = "m/s", .min = 0.02, .max = 2, .doc = "at most"});
  d.param("turn_radps", w.turn_radps, {.unit = "rad/s", .min = 0.05, .max = 6, .doc = "at most"});
  d.param("near_m", w.near_m, {.unit = "m", .min = 0, .max = 3, .doc = "nearer it walks in any direction"});
  d.param("per_s", w.per_s,
          {.unit = "1/s", .min = 0.1, .max = 10, .doc = "speed for each metre or radian that is missing"});
  d.param("margin_m", w.margin_m, {.unit = "m", .min = 0, .max = 1, .doc = "kept from others"});
  d.param("ball_old_s", options_.ball_old_s,
          {.unit = "s", .min = 0.2, .max = 60, .doc = "a ball that was not seen for so long is searched"});
  d.param("search_turn_radps", options_.search_turn_radps,
          {.unit = "rad/s", .min = 0.05, .max = 6, .doc = "while it searches"});
  d.param("near_place_m", options_.near_place_m,
          {.unit = "m", .min = 0.002, .max = 0.2, .doc = "from where it has to stand when it kicks"});
  d.param("near_place_rad", options_.near_place_rad,
          {.unit = "rad", .min = 0.01, .max = 1, .doc = "the same of its heading"});
  d.param("behind_m", options_.behind_m,
          {.unit = "m", .min = 0, .max = 1, .doc = "so far behind that place it goes first"});
  d.param("kick_x_m", kick_x_m_,
          {.unit = "m",
           .min = 0,
           .max = 0.5,
           .doc = "where the ball has to lie for a kick forward with the left foot: ahead"});
  d.param("kick_y_m", kick_y_m_, {.unit = "m", .min = -0.2, .max = 0.5, .doc = "and to the left"});
  d.param("step_kick_x_m", step_kick_x_m_,
          {.unit = "m", .min = 0, .max = 0.5, .doc = "the same of a kick within a step"});
  d.param("step_kick_y_m", step_kick_y_m_, {.unit = "m", .min = -0.2, .max = 0.5, .doc = "and to the left"});
  d.param("out_x_m", out_x_m_, {.unit = "m", .min = -0.2, .max = 0.5, .doc = "the same of a kick outward"});
  d.param("out_y_m", out_y_m_, {.unit = "m", .min = 0, .max = 0.5, .doc = "and to the left"});
  d.param("force", force_, {.min = 0, .max = 1000, .doc = "holds the behaviour in this state; 0: none"});
}

hal::Status PlayBaseline::configure(rt::Setup& setup) {
  add_player(tree_);
  if (behaviour::explain(tree_.resolve(), setup)) return {};
  return hal::Error{hal::Errc::bad_argument, "the behaviour of a player"};
}

void PlayBaseline::reset() {
  progress_ = {};
  chosen_ = {};
  ball_before_ = {0, 0};
  asked_ = 0;
}

void PlayBaseline::read_world(rt::Time now) {
  PlayBoard& b = board_;
  b = {};
  b.options = &options_;
  b.field = &field_;
  b.now_s = 1e-9 * static_cast<double>(now.ns);
  b.player = static_cast<std::uint32_t>(player_);
  b.chosen = chosen_;
  b.ball_before = ball_before_;
  if (const msg::RefereeState* said = referee_.fresh(now)) {
    b.phase = said->phase;
    b.kick_of = said->kick;
    b.penalised = said->penalty != msg::GamePenalty::none;
  }
  if (const msg::FieldPose* pose = pose_.fresh(now)) {
    b.self = {pose->x_m, pose->y_m, pose->heading_rad};
    b.found = pose->found != 0;
  }
  const msg::BallModel* ball = ball_.fresh(now);
  if (ball && ball->seen.ns > 0) {
    b.ball = {ball->x_m, ball->y_m};
    b.ball_mps = {ball->vx_mps, ball->vy_mps};
    b.ball_age_s = age_s(ball->seen, now);
    b.ball_gone = ball->gone != 0;
    b.ball_at = b.self.out(ball->x_m, ball->y_m);
    b.ball_known = b.found && !b.ball_gone && b.ball_age_s < options_.ball_old_s;
  }
  if (const msg::ObstacleModel* seen = obstacles_.fresh(now))
    for (std::uint32_t i = 0; i < seen->obstacles && b.others_n < b.others.size(); ++i) {
      const msg::Obstacle& o = seen->obstacle[i];
      b.others[b.others_n++] = {{o.x_m, o.y_m}, o.radius_m};
    }
}

void PlayBaseline::follow_request(const msg::GaitState& gait) {
  if (asked_ == 0) return;
  if (gait.request == asked_) {
    board_.kick_done = gait.progress == msg::RequestProgress::done;
    board_.kick_failed = gait.progress == msg::RequestProgress::broken_off;
  }
  if (gait.refused == asked_) board_.kick_failed = true;
}

rt::StepStatus PlayBaseline::step(const rt::Step& step) noexcept {
  const msg::GaitState* gait = gait_.fresh(step.now);
  if (!gait) return rt::StepStatus::stale;
  KickOptions& kicks = options_.kicks;
  const FieldPoint ahead{kick_x_m_, kick_y_m_}, within{step_kick_x_m_, step_kick_y_m_}, aside{out_x_m_, out_y_m_};
  constexpr double kAside = 0.5 * math::kPi;
  // Lengths by docs/walking.md; times: of the motions in the motion file, and from asking to done in recorded games.
  kicks.kinds[kForward] = {BallMotion::kick_forward, false, ahead, 0, 1.28, 3.1};
  kicks.kinds[kOutward] = {BallMotion::kick_outward, false, aside, kAside, 1.25, 2.3};
  kicks.kinds[kStepForward] = {BallMotion::kick_forward, true, within, 0, 1.06, 0.6};
  // Not used: where the ball must lie for it was not measured.
  kicks.kinds[kStepOutward] = {BallMotion::kick_outward, true, aside, kAside, 0, 0.6};

  read_world(step.now);
  PlayBoard& b = board_;
  const msg::SafetyState* safety = safety_.get();
  b.may_move = !safety || safety->action == msg::FailsafeAction::none;
  b.on_feet = msg::on_its_feet(gait->mode);
  follow_request(*gait);

  msg::BehaviourState& state = state_.loan();
  tree_.step(progress_, b, step.now, tree_.plan().numbered(force_), state);
  if (progress_.tells_plan(step.now)) {
    msg::BehaviourPlan& plan = plan_.loan();
    tree_.plan().describe("force", plan);
    plan.stamp = step.now;
  }
  chosen_ = b.chosen;
  ball_before_ = b.ball_before;
  if (b.kicks) {
    msg::KickRequest& kick = kick_.loan();
    kick = b.ask;
    kick.stamp = gait->stamp;
    kick.id = ++asked_;
  }
  msg::GazeCommand& gaze = gaze_.loan();
  gaze = b.gaze;
  gaze.stamp = gait->stamp;
  msg::VelocityCommand& velocity = velocity_.loan();
  velocity = {};
  velocity.stamp = gait->stamp;
  velocity.linear_mps = {b.walk.forward_mps, b.walk.left_mps, 0};
  velocity.angular_radps = {0, 0, b.walk.turn_radps};
  return rt::StepStatus::ok;
}

}  // namespace sinew::soccer::baseline
