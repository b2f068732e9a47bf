#include "robots/gripper/fetch.hpp"

#include <algorithm>

#include "math/elementary.hpp"
#include "math/linear.hpp"
#include "robots/gripper/delivery.hpp"

namespace sinew::gripper {

using namespace std::chrono_literals;
using msg::MissionPhase;

namespace {

constexpr double kSame_m = 0.25;  // sightings that differ by more are of different balls
constexpr std::uint32_t kEnoughSightings = 3;
constexpr double kShare = 0.4;                      // of a sighting in the ball's place
constexpr double kFarthest_m = 4;                   // a ray that meets the ground further away says nothing
constexpr double kNear_m = 0.6, kLevel_rad = 0.06;  // nearer than this it has to look at the ball before it drives on
constexpr double kTurn_per_s = 1.8, kDrive_per_s = 0.9, kAhead_rad = 0.5;
constexpr double kForgotten_s = 1.5;  // a ball that should be in sight and is not
constexpr double kBlind_m = 0.65;     // nearer than this the ball leaves the picture
constexpr double kStall_radps = 0.3, kStall_s = 0.3;
constexpr double kLookFrom_m = 0.8;             // from the team's ball: it looks for it by itself
constexpr double kTells_s = 4, kBrought_s = 2;  // that the ball is at the goal; so long it is said to be there
constexpr double kSigma_m = 0.03, kSigmaShare = 0.05, kBallSeen_s = 5;
constexpr double kBack_m = 0.5, kBack_mps = 0.25, kOpen_rad = 0.6, kLongest_s = 4;

}  // namespace

void Fetch::declare(rt::Declaration& d) {
  d.in("state", state_, {.max_age = 200ms, .previous = true});
  d.in("joint", gripper_joint_, {.max_age = 200ms});
  d.in("ball", ball_, {.max_age = 500ms});
  d.in("safety", safety_, {.optional = true, .supervises = true});
  d.in("team", team_, {.max_age = 2s, .optional = true});
  d.in("field", field_, {.max_age = 200ms, .optional = true, .previous = true});
  d.out("velocity", velocity_);
  d.out("gripper", gripper_, {.channels = 1});
  d.out("mission", mission_);
  d.out("own_ball", ball_model_);
  d.state(past_, ball_at_, mark_, in_phase_s_, stalled_s_, unseen_s_, since_, ball_stamp_, phase_, sightings_, closes_,
          backs_off_, brought_s_, told_s_, looked_s_, start_, team_ball_, known_, wall_end_);
  d.param("camera_x_m", camera_x_m_, {.unit = "m", .min = -1, .max = 1, .doc = "of the camera before the wheels"});
  d.param("camera_z_m", camera_z_m_, {.unit = "m", .min = 0.05, .max = 2, .doc = "of the camera above the ground"});
  d.param("camera_down_rad", camera_down_rad_, {.unit = "rad", .min = 0, .max = 1.4, .doc = "how far it looks down"});
  d.param("ball_radius_m", ball_radius_m_,
          {.unit = "m", .min = 0.01, .max = 0.5, .doc = "its middle is so high above the ground"});
  d.param("grip_at_m", grip_at_m_,
          {.unit = "m", .min = 0.1, .max = 1, .doc = "from the wheels to a ball in the gripper"});
  d.param("closed_rad", closed_rad_, {.unit = "rad", .min = 0, .max = 100, .doc = "of the gripper's motor; open is 0"});
  d.param("held_from_rad", held_from_rad_,
          {.unit = "rad", .min = 0, .max = 100, .doc = "it holds a ball where it stalls between this"});
  d.param("held_to_rad", held_to_rad_, {.unit = "rad", .min = 0, .max = 100, .doc = "and this"});
  d.param("fast_mps", fast_mps_, {.unit = "m/s", .min = 0.05, .max = 1.5, .doc = "to the ball"});
  d.param("slow_mps", slow_mps_, {.unit = "m/s", .min = 0.02, .max = 1, .doc = "the last bit of it"});
  d.param("carry_mps", carry_mps_, {.unit = "m/s", .min = 0.05, .max = 1.5, .doc = "with the ball"});
  d.param("search_radps", search_radps_,
          {.unit = "rad/s", .min = 0.1, .max = 2, .doc = "turning while it looks for the ball"});
  d.param("wait_s", wait_s_,
          {.unit = "s", .min = 0.5, .max = 60, .doc = "before it begins: the gyro's offset is measured"});
  d.param("home_within_m", home_within_m_,
          {.unit = "m", .min = 0.02, .max = 1, .doc = "how near to its start, or the goal, it lets the ball go"});
  d.param("for_team", for_team_, {.doc = "it fetches when the team needs it, and brings the ball to the goal"});
  d.param("goal_x_m", goal_x_m_, {.unit = "m", .min = -10, .max = 10, .doc = "of a team: along the field"});
  d.param("goal_y_m", goal_y_m_, {.unit = "m", .min = -10, .max = 10, .doc = "and across the field"});
  d.param("wall_x_m", wall_.x_m, {.unit = "m", .min = -10, .max = 10, .doc = "a wall across the field stands here"});
  d.param("wall_from_y_m", wall_.from_y_m, {.unit = "m", .min = -10, .max = 10, .doc = "it begins here"});
  d.param("wall_to_y_m", wall_.to_y_m,
          {.unit = "m", .min = -10, .max = 10, .doc = "and ends here; not farther to the left: there is none"});
  d.param("mate_radius_m", mate_radius_m_, {.unit = "m", .min = 0.05, .max = 1, .doc = "of a mate that is in the way"});
  d.param("margin_m", margin_m_, {.unit = "m", .min = 0.05, .max = 1, .doc = "from its middle to what is in the way"});
  d.param("brought_within_m", brought_within_m_,
          {.unit = "m", .min = 0.05, .max = 2, .doc = "a ball so near to the goal has been brought"});
}

void Fetch::reset() {
  past_.clear();
  ball_at_ = mark_ = {};
  in_phase_s_ = stalled_s_ = unseen_s_ = 0;
  since_ = ball_stamp_ = {};
  phase_ = MissionPhase::wait;
  sightings_ = closes_ = backs_off_ = 0;
  brought_s_ = told_s_ = looked_s_ = 0;
  start_ = {};
  team_ball_ = {};
  known_ = {};
  wall_end_ = WallEnd::none;
}

void Fetch::enter(MissionPhase phase, rt::Time now) {
  phase_ = phase;
  in_phase_s_ = stalled_s_ = 0;
  since_ = now;
}

/// Where the ray to the ball's middle is as high as that middle, from where the robot was at the exposure.
void Fetch::see(const msg::BallSighting& ball) {
  if (ball.stamp == ball_stamp_) return;
  ball_stamp_ = ball.stamp;
  const auto then = past_.at(ball.stamp);
  if (ball.found == 0 || !then) return;
  const math::Vec3 d(ball.direction_optical);  // x right, y down, z ahead
  const math::SinCos down = math::sincos(camera_down_rad_);
  const math::Vec3 ray{d.z * down.cos - d.y * down.sin, -d.x, -d.z * down.sin - d.y * down.cos};
  if (!(ray.z < 0)) return;
  const double far = (ball_radius_m_ - camera_z_m_) / ray.z;
  if (!(far > 0 && far < kFarthest_m)) return;
  const math::Vec3 at = then->p_world_m + then->q_world_base.rotate({camera_x_m_ + far * ray.x, far * ray.y, 0});
  unseen_s_ = 0;
  if (sightings_ > 0 && math::hypot(at.x - ball_at_.x_m, at.y - ball_at_.y_m) < kSame_m) {
    sightings_ = std::min(sightings_ + 1, 1000u);
    ball_at_.x_m += kShare * (at.x - ball_at_.x_m);
    ball_at_.y_m += kShare * (at.y - ball_at_.y_m);
  } else {
    sightings_ = 1;
    ball_at_ = {at.x, at.y};
  }
}

bool Fetch::has_stalled(const msg::JointState& gripper) const {
  return math::fabs(gripper.velocity_radps[0]) < kStall_radps;
}

Fetch::Drive Fetch::drive_to(Point to, double stop_m, const msg::NavState& state) {
  double x = to.x_m - state.p_world_m.x, y = to.y_m - state.p_world_m.y;
  if (known_.start != 0 && wall_.stands()) {
    const soccer::FieldPoint here = start_.out(state.p_world_m.x, state.p_world_m.y);
    const soccer::FieldPoint next = way_round(here, start_.out(to.x_m, to.y_m), wall_, margin_m_, wall_end_);
    const soccer::FieldPoint own = start_.in(next.x_m, next.y_m);
    if (wall_end_ != WallEnd::none) x = own.x_m - state.p_world_m.x, y = own.y_m - state.p_world_m.y, stop_m = 0;
  }
  double aside = math::wrap_pi(math::atan2(y, x) - math::Quat(state.q_world_base).yaw());
  const double far_m = math::hypot(x, y), left_m = far_m - stop_m;
  if (rounds_ > 0 && far_m > kNear_m) {
    const math::SinCos t = math::sincos(aside);
    aside = soccer::way_rad({far_m * t.cos, far_m * t.sin}, std::span(round_).first(rounds_), margin_m_);
  }
  Drive drive{std::max(0.0, kDrive_per_s * left_m), kTurn_per_s * aside};
  const double most_aside = left_m + stop_m < kNear_m && wall_end_ == WallEnd::none ? kLevel_rad : kAhead_rad;
  if (wall_end_ != WallEnd::none) drive.forward_mps = fast_mps_;  // it does not stop at a corner
  if (math::fabs(aside) > most_aside) drive.forward_mps = 0;
  return drive;
}

Fetch::Drive Fetch::look_for_ball(const msg::NavState& state, rt::Time now) {
  if (backs_off_ != 0) {
    const double back_m = math::hypot(state.p_world_m.x - mark_.x_m, state.p_world_m.y - mark_.y_m);
    if (back_m < kBack_m && in_phase_s_ < kLongest_s) return {-kBack_mps, 0};
    backs_off_ = 0;
    sightings_ = 0;  // it moved
  }
  if (sightings_ >= kEnoughSightings && unseen_s_ < 0.3) enter(MissionPhase::approach, now);
  if (known_.team_ball != 0 && !(sightings_ > 0 && unseen_s_ < 0.5)) {
    const double far_m = math::hypot(team_ball_.x_m - state.p_world_m.x, team_ball_.y_m - state.p_world_m.y);
    if (far_m > kLookFrom_m) {
      Drive drive = drive_to(team_ball_, kLookFrom_m / 2, state);
      drive.forward_mps = std::min(drive.forward_mps, fast_mps_);
      looked_s_ = 0;
      return drive;
    }
    looked_s_ += dt_s_;
    if (looked_s_ > 2.2 * math::kPi / search_radps_) known_.team_ball = 0, looked_s_ = 0;
  }
  // Not past a ball that was seen once.
  return {0, sightings_ > 0 && unseen_s_ < 0.5 ? 0 : search_radps_};
}

Fetch::Drive Fetch::approach(const msg::NavState& state, rt::Time now) {
  const double far_m = math::hypot(ball_at_.x_m - state.p_world_m.x, ball_at_.y_m - state.p_world_m.y);
  if (far_m > kBlind_m && unseen_s_ > kForgotten_s) {
    sightings_ = 0;
    enter(MissionPhase::search, now);
    return {};
  }
  Drive drive = drive_to(ball_at_, grip_at_m_, state);
  const bool near = far_m < kNear_m;
  if (near && far_m - grip_at_m_ < 0.01) {
    closes_ = 1;
    enter(MissionPhase::hold, now);
    return {};
  }
  // The ball is driven at slowly, so that it is not kicked; never so slowly that it is not reached.
  if (drive.forward_mps > 0) drive.forward_mps = std::clamp(drive.forward_mps, slow_mps_, near ? slow_mps_ : fast_mps_);
  return drive;
}

Fetch::Drive Fetch::close(const msg::JointState& gripper, rt::Time now) {
  if (in_phase_s_ < 0.4) stalled_s_ = 0;  // it has not begun to move
  if (stalled_s_ < kStall_s && in_phase_s_ < kLongest_s) return {};
  const double rad = gripper.position_rad[0];
  if (rad >= held_from_rad_ && rad <= held_to_rad_) {
    enter(MissionPhase::descend, now);
  } else {
    closes_ = 0;
    backs_off_ = 1;
    enter(MissionPhase::search, now);
  }
  return {};
}

Fetch::Drive Fetch::bring(const msg::NavState& state, const msg::JointState& gripper, rt::Time now) {
  if (gripper.position_rad[0] > held_to_rad_) {  // it slipped out
    closes_ = 0;
    backs_off_ = 1;
    enter(MissionPhase::search, now);
    return {};
  }
  const Point to = goal();
  Drive drive = drive_to(to, grip_at_m_, state);
  const double left_m = math::hypot(to.x_m - state.p_world_m.x, to.y_m - state.p_world_m.y) - grip_at_m_;
  if (left_m < home_within_m_) {
    closes_ = 0;
    const math::Vec3 held = math::Vec3(state.p_world_m) + math::Quat(state.q_world_base).rotate({grip_at_m_, 0, 0});
    ball_at_ = {held.x, held.y};
    enter(MissionPhase::touchdown, now);
    return {};
  }
  drive.forward_mps = drive.forward_mps > 0 ? std::clamp(drive.forward_mps, slow_mps_, carry_mps_) : 0;
  return drive;
}

Fetch::Drive Fetch::let_go(const msg::NavState& state, const msg::JointState& gripper, rt::Time now) {
  if (backs_off_ == 0) {
    mark_ = {state.p_world_m.x, state.p_world_m.y};
    backs_off_ = gripper.position_rad[0] < kOpen_rad || in_phase_s_ > kLongest_s ? 1 : 0;
    return {};
  }
  if (math::hypot(state.p_world_m.x - mark_.x_m, state.p_world_m.y - mark_.y_m) >= kBack_m ||
      in_phase_s_ > 3 * kLongest_s) {
    if (!for_team_ || told_s_ > kTells_s) enter(MissionPhase::done, now);
    return {};
  }
  return {-kBack_mps, 0};
}

/// What the team says, and what is in the way.
void Fetch::hear(const msg::NavState& state, double dt_s, rt::Time now) {
  rounds_ = 0;
  if (!for_team_) return;
  const soccer::FieldAt here{state.p_world_m.x, state.p_world_m.y, math::Quat(state.q_world_base).yaw()};
  const msg::FieldPose* field = field_.fresh(now);
  if (field && field->stamp == state.stamp) {
    const soccer::FieldAt on_field{field->x_m, field->y_m, field->heading_rad};
    start_ = on_field.then(here.way_to({0, 0, 0}));
    known_.start = 1;
  }
  const msg::TeamModel* team = team_.fresh(now);
  if (known_.start == 0) return;
  const soccer::FieldAt on_field = start_.then(here);
  const auto add = [&](double x_m, double y_m, double radius_m) {
    if (rounds_ < round_.size()) round_[rounds_++] = {on_field.in(x_m, y_m), radius_m};
  };
  if (!team) return;
  // Also one that has fallen silent stands where it was.
  for (const msg::SoccerReport& mate : team->mate)
    if (mate.stamp.ns > 0) add(double{mate.x_m}, double{mate.y_m}, mate_radius_m_);
  if (team->ball_seen.ns > 0 && msg::seconds(now - team->ball_seen) < kBallSeen_s) {
    const soccer::FieldPoint at = start_.in(team->ball_x_m, team->ball_y_m);
    team_ball_ = {at.x_m, at.y_m};
    known_.team_ball = 1;  // until it has looked there: on its way it may hide the ball from who saw it
  }
  const bool brought = gripper::lies_at(*team, {goal_x_m_, goal_y_m_}, brought_within_m_, now);
  brought_s_ = brought ? brought_s_ + dt_s : 0;
}

bool Fetch::may_fetch(rt::Time now) const {
  if (!for_team_) return true;
  const msg::TeamModel* team = team_.fresh(now);
  return team && known_.start != 0 && team->mates > 0 && team->role == msg::SoccerRole::striker;
}

Fetch::Point Fetch::goal() const {
  if (!for_team_) return {};
  const soccer::FieldPoint at = start_.in(goal_x_m_, goal_y_m_);
  return {at.x_m, at.y_m};
}

/// Where the ball is, as far as it knows by itself.
void Fetch::tell(const msg::NavState& state, rt::Time now) {
  msg::BallModel& ball = ball_model_.loan();
  ball.stamp = state.stamp;
  const bool holds = phase_ == MissionPhase::descend, let_go = phase_ == MissionPhase::touchdown;
  const bool saw = sightings_ >= kEnoughSightings && unseen_s_ < kBallSeen_s &&
                   (phase_ == MissionPhase::search || phase_ == MissionPhase::approach || phase_ == MissionPhase::hold);
  if (!holds && !let_go && !saw) return;
  const soccer::FieldAt here{state.p_world_m.x, state.p_world_m.y, math::Quat(state.q_world_base).yaw()};
  const soccer::FieldPoint at = holds ? soccer::FieldPoint{grip_at_m_, 0} : here.in(ball_at_.x_m, ball_at_.y_m);
  ball.x_m = at.x_m, ball.y_m = at.y_m;
  ball.seen = saw ? msg::Time{now.ns - static_cast<std::int64_t>(1e9 * unseen_s_)} : now;
  ball.confidence = saw ? 0.9 * (1 - unseen_s_ / kBallSeen_s) : 0.95;
  const double sigma_m = kSigma_m + kSigmaShare * math::hypot(at.x_m, at.y_m);
  ball.covariance[0] = ball.covariance[5] = sigma_m * sigma_m;
  ball.covariance[10] = ball.covariance[15] = 0.01;
  const soccer::FieldPoint field = start_.then(here).out(at.x_m, at.y_m);
  ball.field_x_m = field.x_m, ball.field_y_m = field.y_m;
  ball.sightings = sightings_;
}

Fetch::Drive Fetch::act(const msg::NavState& state, const msg::JointState& gripper, rt::Time now) {
  const bool may_leave = phase_ == MissionPhase::search || phase_ == MissionPhase::approach;
  if (may_leave && (brought_s_ > kBrought_s || !may_fetch(now))) {
    closes_ = backs_off_ = 0;
    enter(MissionPhase::wait, now);
  }
  switch (phase_) {
    case MissionPhase::wait:
      if (brought_s_ > kBrought_s)
        enter(MissionPhase::done, now);
      else if (in_phase_s_ >= wait_s_ && may_fetch(now))
        enter(MissionPhase::search, now);
      return {};
    case MissionPhase::search:
      return look_for_ball(state, now);
    case MissionPhase::approach:
      return approach(state, now);
    case MissionPhase::hold:
      mark_ = {state.p_world_m.x, state.p_world_m.y};
      return close(gripper, now);
    case MissionPhase::descend:
      mark_ = {state.p_world_m.x, state.p_world_m.y};
      return bring(state, gripper, now);
    case MissionPhase::touchdown:
      return let_go(state, gripper, now);
    default:
      return {};
  }
}

rt::StepStatus Fetch::step(const rt::Step& step) noexcept {
  const msg::NavState* state = state_.fresh(step.now);
  const msg::JointState* gripper = gripper_joint_.fresh(step.now);
  if (!state || !gripper || gripper->count < 1 || !math::is_finite(gripper->position_rad[0]))
    return rt::StepStatus::stale;
  const double dt_s = dt_s_ = msg::seconds(step.dt);
  in_phase_s_ += dt_s;
  unseen_s_ += dt_s;
  stalled_s_ = has_stalled(*gripper) ? stalled_s_ + dt_s : 0;
  told_s_ = phase_ == MissionPhase::touchdown ? told_s_ + dt_s : 0;
  hear(*state, dt_s, step.now);
  past_.add({state->stamp, math::Vec3(state->p_world_m), math::Quat(state->q_world_base)});
  const msg::BallSighting* ball = ball_.fresh(step.now);
  const bool looks = phase_ == MissionPhase::search || phase_ == MissionPhase::approach;
  if (ball && looks) see(*ball);
  const msg::SafetyState* safety = safety_.get();
  const bool calm = !safety || safety->action == msg::FailsafeAction::none;
  if (!calm && phase_ != MissionPhase::done) enter(MissionPhase::done, step.now);
  const Drive drive = act(*state, *gripper, step.now);

  tell(*state, step.now);

  msg::VelocityCommand& velocity = velocity_.loan();
  velocity.stamp = state->stamp;
  velocity.linear_mps.x = drive.forward_mps;
  velocity.angular_radps.z = drive.turn_radps;
  msg::ActuatorCommand& command = gripper_.loan();
  command.stamp = gripper->stamp;
  command.count = 1;
  command.armed = 1;
  command.value[0] = closes_ != 0 ? closed_rad_ : 0;
  msg::MissionState& mission = mission_.loan();
  mission.stamp = step.now;
  mission.phase_since = since_;
  mission.phase = phase_;
  mission.target_world_m = {ball_at_.x_m, ball_at_.y_m, ball_radius_m_};
  return rt::StepStatus::ok;
}

}  // namespace sinew::gripper
