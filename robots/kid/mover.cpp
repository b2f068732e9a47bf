#include "robots/kid/mover.hpp"

#include <algorithm>
#include <string>

#include "motion/kept_numbers.hpp"
#include "robots/kid/devices.hpp"

namespace sinew::kid {

using namespace std::chrono_literals;
using kinematics::kLimbs;
using motion::PoseMotion;
using msg::BallMotion;
using msg::GaitMode;
using msg::RequestProgress;
using msg::RequestRefusal;

namespace {

constexpr double kMostJoint_rad = 7, kMostGyro_radps = 50, kMostAccel_mps2 = 200, kMostCell_n = 2000;
constexpr double kUpright = 0.9, kUprightS = 1;  // of a body that did not fall after all
constexpr double kLieS = 0.3;                    // it lies still before it rises
constexpr double kLeanS = 1.2;                   // it leans on its limbs, and does not come to lie

motion::Side side_of(msg::Foot foot) { return foot == msg::Foot::left ? motion::Side::left : motion::Side::right; }
motion::KickWay way_of(BallMotion motion) {
  return motion == BallMotion::kick_outward ? motion::KickWay::outward : motion::KickWay::forward;
}

bool within(double value, double most) { return value > -most && value < most; }
bool within(const msg::Vec3& v, double most) { return within(v.x, most) && within(v.y, most) && within(v.z, most); }

template <class T>
void declare_params(rt::Declaration& d, const std::string& prefix, std::span<const motion::Param<T>> table, T& values) {
  for (const motion::Param<T>& row : table)
    d.param(prefix + std::string(row.name), values.*row.value,
            {.unit = row.unit, .min = row.least, .max = row.most, .doc = row.doc});
}

}  // namespace

/// What the motion file says is the default of the parameters, which a robot file may still change.
Mover::Mover(robots::RobotBody robot) : robot_(std::move(robot)) {
  if (!robot_.motions) return;
  walk_params_ = robot_.motions->walk;
  fall_params_ = robot_.motions->fall;
  kick_forward_ = robot_.motions->kick_forward;
  kick_outward_ = robot_.motions->kick_outward;
  step_kick_forward_ = robot_.motions->step_kick_forward;
  step_kick_outward_ = robot_.motions->step_kick_outward;
  stop_params_ = robot_.motions->stop;
}

void Mover::declare(rt::Declaration& d) {
  d.in("imu", imu_, {.max_age = 100ms});
  d.in("soles", soles_, {.max_age = 100ms});
  for (std::size_t i = 0; i < kLimbs; ++i)
    d.in(std::string(to_string(kinematics::Limb(i))) + "_joints", joints_[i], {.max_age = 100ms});
  d.in("velocity", velocity_, {.max_age = 300ms, .optional = true});
  d.in("kick", requests_, {.depth = 16, .optional = true});
  d.in("safety", safety_, {.optional = true, .supervises = true});
  for (std::size_t i = 0; i < kLimbs; ++i)
    d.out(to_string(kinematics::Limb(i)), limb_[i], {.channels = plant::kKidLimbJoints[i]});
  d.out("gait", gait_);
  d.state(rad_, targets_, kept_, since_, mode_, falls_, plays_, height_m_, request_, progress_, refused_, refusal_);
  declare_params<motion::WalkParams>(d, "", motion::kWalkParams, walk_params_);
  declare_params<motion::FallParams>(d, "fall_", motion::kFallParams, fall_params_);
  declare_params<motion::KickParams>(d, "kick_forward_", motion::kKickParams, kick_forward_);
  declare_params<motion::KickParams>(d, "kick_outward_", motion::kKickParams, kick_outward_);
  declare_params<motion::StepKickParams>(d, "step_kick_forward_", motion::kStepKickParams, step_kick_forward_);
  declare_params<motion::StepKickParams>(d, "step_kick_outward_", motion::kStepKickParams, step_kick_outward_);
  declare_params<motion::BallStopParams>(d, "stop_", motion::kBallStopParams, stop_params_);
}

hal::Status Mover::configure(rt::Setup& setup) {
  if (!robot_.body || !robot_.motions) {
    setup.explain("it needs [body] and [motions] in the robot file (docs/walking.md)");
    return hal::Error{hal::Errc::bad_argument, "a body and its motions"};
  }
  const kinematics::Body& body = *robot_.body;
  std::string why;
  figure_ = motion::Figure::make(body, why);
  if (!figure_) {
    setup.explain(why);
    return hal::Error{hal::Errc::bad_argument, "a body that walks"};
  }
  limbs_ = kinematics::Limbs::of(body);
  for (std::size_t i = 0; i < kLimbs; ++i)
    if (limbs_.joints[i].size() > plant::kKidLimbJoints[i]) {
      setup.explain(std::string(to_string(kinematics::Limb(i))) + " of the body has " +
                    std::to_string(limbs_.joints[i].size()) + " joints; at most " +
                    std::to_string(plant::kKidLimbJoints[i]));
      return hal::Error{hal::Errc::bad_argument, "joints of a limb"};
    }
  const std::size_t joints = body.joints();
  walk_ = std::make_unique<motion::Walk>(*figure_, std::span(robot_.motions->rest_rad).first(joints));
  kick_ = std::make_unique<motion::Kick>(*figure_, walk_params_, std::span(robot_.motions->rest_rad).first(joints));
  stop_ = std::make_unique<motion::BallStop>(*figure_, walk_params_, std::span(robot_.motions->rest_rad).first(joints));
  pose_motions_.emplace(*robot_.motions, body);
  rad_.assign(joints, 0);
  targets_.assign(joints, 0);
  if (const kinematics::Place* imu = body.find_place("imu")) q_torso_imu_ = imu->pose.q;
  at_begin_.assign(motion::count_numbers(*walk_) + motion::count_numbers(fall_) + motion::count_numbers(poses_) +
                       motion::count_numbers(*kick_) + motion::count_numbers(*stop_),
                   0);
  write_motions(at_begin_);
  kept_ = at_begin_;
  return {};
}

void Mover::reset() {
  std::ranges::fill(rad_, 0);
  std::ranges::fill(targets_, 0);
  std::ranges::copy(at_begin_, kept_.begin());
  since_ = {};
  mode_ = GaitMode::limp;
  falls_ = 0;
  plays_ = PoseMotion::none;
  height_m_ = 0;
  request_ = {};
  progress_ = RequestProgress::none;
  refused_ = 0;
  refusal_ = RequestRefusal::none;
}

void Mover::enter(GaitMode mode, rt::Time now) noexcept {
  if (mode_ == mode) return;
  if (mode == GaitMode::fall && msg::on_its_feet(mode_)) ++falls_;  // not when it has not come up yet
  mode_ = mode;
  since_ = now;
}

/// False: those of a leg are missing or old.
bool Mover::sense_joints(rt::Time now) noexcept {
  for (std::size_t i = 0; i < kLimbs; ++i) {
    const msg::JointState* state = joints_[i].fresh(now);
    const bool is_leg =
        kinematics::Limb(i) == kinematics::Limb::left_leg || kinematics::Limb(i) == kinematics::Limb::right_leg;
    if (!state && is_leg) return false;
    if (!state) continue;  // an arm that is lost stays where it was last seen
    for (std::size_t c = 0; c < limbs_.joints[i].size() && c < state->count; ++c)
      rad_[limbs_.joints[i][c]] = state->position_rad[c];
    if (is_leg) measured_ = state->stamp;
  }
  sensed_.joints_rad = rad_;
  return true;
}

/// False: what balance needs is missing, old or nonsense.
bool Mover::sense_balance(rt::Time now) noexcept {
  const msg::ImuSample* imu = imu_.fresh(now);
  const msg::SolePressure* soles = soles_.fresh(now);
  if (!imu || !soles || !within(imu->gyro_radps, kMostGyro_radps) || !within(imu->accel_mps2, kMostAccel_mps2))
    return false;
  for (const double n : soles->force_n)
    if (!within(n, kMostCell_n)) return false;
  sensed_.gyro_radps = q_torso_imu_.rotate(math::Vec3(imu->gyro_radps));
  sensed_.accel_mps2 = q_torso_imu_.rotate(math::Vec3(imu->accel_mps2));
  for (std::size_t cell = 0; cell < msg::kSoleCells; ++cell) sensed_.soles_n[cell / 4][cell % 4] = soles->force_n[cell];
  return true;
}

motion::WalkCommand Mover::command(rt::Time now) const noexcept {
  const msg::VelocityCommand* wanted = velocity_.fresh(now);
  if (failsafe_acts() || stands_for_it()) return {};
  if (!wanted) return {.walk = is_open()};
  motion::WalkCommand c{wanted->linear_mps.x, wanted->linear_mps.y, wanted->angular_radps.z, true};
  if (!within(wanted->linear_mps, 10) || !within(wanted->angular_radps, 50)) return {.walk = is_open()};
  c.walk = is_open() || c.forward_mps != 0 || c.left_mps != 0 || c.turn_radps != 0;
  return c;
}

bool Mover::failsafe_acts() const noexcept {
  const msg::SafetyState* safety = safety_.get();
  return safety && safety->action != msg::FailsafeAction::none;
}

bool Mover::is_open() const noexcept {
  return progress_ == RequestProgress::waits || progress_ == RequestProgress::moves;
}

bool Mover::stands_for_it() const noexcept { return is_open() && request_.in_walk == 0; }

RequestRefusal Mover::refusal_of(const msg::KickRequest& r) const noexcept {
  if (r.motion > BallMotion::stop || r.foot > msg::Foot::right) return RequestRefusal::unknown;
  if (is_open()) return RequestRefusal::busy;
  if (!msg::on_its_feet(mode_)) return RequestRefusal::not_on_feet;
  return failsafe_acts() ? RequestRefusal::failsafe : RequestRefusal::none;
}

void Mover::take_requests() noexcept {
  for (const msg::KickRequest& r : requests_) {
    if (const RequestRefusal refusal = refusal_of(r); refusal != RequestRefusal::none) {
      refused_ = r.id;
      refusal_ = refusal;
      continue;
    }
    request_ = r;
    if (r.motion == BallMotion::stop) request_.in_walk = 0;
    progress_ = RequestProgress::waits;
  }
}

/// On its feet, and the walk has the joints: a step that is a kick, or a stand that is long enough, begins it.
void Mover::begin_request(const rt::Step& step) noexcept {
  if (progress_ != RequestProgress::waits || failsafe_acts()) return;
  const motion::Side side = side_of(request_.foot);
  if (request_.in_walk != 0) {
    if (walk_->kicking())
      progress_ = RequestProgress::moves;
    else if (!walk_->kicks())
      walk_->kick(side, way_of(request_.motion));
    return;
  }
  if (mode_ != GaitMode::stand || msg::seconds(step.now - since_) <= walk_params_.settle_s) return;
  progress_ = RequestProgress::moves;
  if (request_.motion == BallMotion::stop) {
    stop_->start(side);
    return enter(GaitMode::stop, step.now);
  }
  kick_->start(side, way_of(request_.motion));
  enter(GaitMode::kick, step.now);
}

/// A motion that has the joints until it ends in a stand.
void Mover::move_at_ball(const rt::Step& step) noexcept {
  const math::Vec3& rate = walk_->tilt.rate_radps();
  if (mode_ == GaitMode::stop)
    stop_->step(walk_->q_world_torso(), rate, msg::seconds(step.dt), targets_);
  else
    kick_->step(walk_->q_world_torso(), rate, msg::seconds(step.dt), targets_);
  if (mode_ == GaitMode::stop ? stop_->active() : kick_->active()) return;
  walk_->take_over(sensed_);
  enter(GaitMode::stand, step.now);
}

/// Whether the request has ended, at the end of a step.
void Mover::follow_request() noexcept {
  if (!is_open()) return;
  const bool waits = progress_ == RequestProgress::waits;
  if (!msg::on_its_feet(mode_) || (waits && failsafe_acts())) {
    progress_ = RequestProgress::broken_off;
    walk_->forget_kick();
  } else if (!waits && mode_ != GaitMode::kick && mode_ != GaitMode::stop) {
    progress_ = RequestProgress::done;
  }
}

/// From where the joints are.
bool Mover::play(PoseMotion motion) noexcept {
  const std::vector<motion::KeyPose>* poses = pose_motions_->poses(motion);
  if (!poses) return false;
  plays_ = motion;
  poses_.start(*poses, rad_);
  return true;
}

/// A body at rest on the ground rises; from its side it turns onto its front first, and one that leans on its own limbs
/// stretches them.
void Mover::get_up(const rt::Step& step) noexcept {
  const math::Vec3 up = walk_->tilt.up();
  if (mode_ != GaitMode::rise) {
    if (!play(pose_motions_->rise_from(motion::lying(up), plays_))) return;
    enter(GaitMode::rise, step.now);
  }
  poses_.step(up, msg::seconds(step.dt), targets_);
  if (poses_.state() == motion::PosePlayer::State::playing) return;
  const bool stands = poses_.state() == motion::PosePlayer::State::done && up.z > kUpright;
  fall_.reset();
  if (stands) walk_->take_over(sensed_);
  enter(stands ? GaitMode::stand : GaitMode::fall, step.now);
}

/// Not interrupted, and no fall: it is low, and its hands are on the way to the ground.
void Mover::get_down(const rt::Step& step) noexcept {
  if (mode_ != GaitMode::down) {
    if (!play(PoseMotion::get_down)) return;
    enter(GaitMode::down, step.now);
  }
  poses_.step(walk_->tilt.up(), msg::seconds(step.dt), targets_);
}

bool Mover::asks_to_land() const noexcept {
  const msg::SafetyState* safety = safety_.get();
  return safety && safety->action == msg::FailsafeAction::land;
}

void Mover::move(const rt::Step& step) noexcept {
  const msg::SafetyState* safety = safety_.get();
  if (safety && (safety->permitted == 0 || safety->action == msg::FailsafeAction::stop))
    return enter(GaitMode::limp, step.now);
  if (mode_ == GaitMode::limp) {
    walk_->reset(sensed_);
    fall_.reset();
    enter(GaitMode::stand, step.now);
  }
  const double dt_s = msg::seconds(step.dt);
  const bool upright = msg::on_its_feet(mode_);
  // A kick within a step is the walk's; other motions at a ball have the joints for themselves.
  const bool at_ball = mode_ == GaitMode::stop || (mode_ == GaitMode::kick && request_.in_walk == 0);
  if (upright && !at_ball)
    walk_->step(command(step.now), sensed_, dt_s, targets_);
  else
    walk_->sense_only(sensed_, dt_s);
  if (mode_ == GaitMode::rise) return get_up(step);
  if (mode_ == GaitMode::down) return get_down(step);
  fall_.step(walk_->tilt.up(), walk_->tilt.rate_radps(), dt_s);
  if (upright && fall_.gives_way()) return enter(GaitMode::fall, step.now);
  if (at_ball) return move_at_ball(step);
  if (upright) {
    const bool stands = walk_->phase() == motion::WalkPhase::stand;
    enter(walk_->kicking() ? GaitMode::kick : (stands ? GaitMode::stand : GaitMode::walk), step.now);
    begin_request(step);
    if (stands && asks_to_land() && msg::seconds(step.now - since_) > walk_params_.settle_s) get_down(step);
    return;
  }
  const bool leans = std::min(fall_.rests_s(), msg::seconds(step.now - since_)) > kLeanS;
  if (mode_ == GaitMode::fall && (fall_.lies() || leans)) enter(GaitMode::lie, step.now);
  if (mode_ == GaitMode::lie && msg::seconds(step.now - since_) > kLieS) get_up(step);
  if (walk_->tilt.up().z > kUpright && msg::seconds(step.now - since_) > kUprightS) enter(GaitMode::limp, step.now);
}

void Mover::write_motions(std::span<double> out) noexcept {
  out = out.subspan(motion::write_numbers(*walk_, out));
  out = out.subspan(motion::write_numbers(fall_, out));
  out = out.subspan(motion::write_numbers(poses_, out));
  out = out.subspan(motion::write_numbers(*kick_, out));
  motion::write_numbers(*stop_, out);
}

void Mover::read_motions() noexcept {
  std::span<const double> in = kept_;
  in = in.subspan(motion::read_numbers(*walk_, in));
  in = in.subspan(motion::read_numbers(fall_, in));
  in = in.subspan(motion::read_numbers(poses_, in));
  in = in.subspan(motion::read_numbers(*kick_, in));
  motion::read_numbers(*stop_, in);
  poses_.resume(pose_motions_->poses(plays_));
}

rt::StepStatus Mover::step(const rt::Step& step) noexcept {
  take_requests();
  if (!sense_joints(step.now)) return rt::StepStatus::stale;
  for (const double rad : rad_)
    if (!within(rad, kMostJoint_rad)) return rt::StepStatus::fault;
  const bool balances = sense_balance(step.now);
  const bool can_get_down = pose_motions_->has(PoseMotion::get_down);
  if (!balances && !(can_get_down && (msg::on_its_feet(mode_) || mode_ == GaitMode::down)))
    return rt::StepStatus::stale;
  read_motions();
  walk_->params = walk_params_;
  walk_->kick_forward = step_kick_forward_;
  walk_->kick_outward = step_kick_outward_;
  fall_.params = fall_params_;
  kick_->forward = kick_forward_;
  kick_->outward = kick_outward_;
  stop_->params = stop_params_;
  if (balances)
    move(step);
  else
    get_down(step);
  if (balances) height_m_ = std::max(walk_->stance().height_m[0], walk_->stance().height_m[1]);
  follow_request();
  write_motions(kept_);
  publish();
  return rt::StepStatus::ok;
}

void Mover::publish() noexcept {
  const bool moves = msg::on_its_feet(mode_) || mode_ == GaitMode::rise ||
                     (mode_ == GaitMode::down && poses_.state() == motion::PosePlayer::State::playing);
  for (std::size_t i = 0; i < kLimbs; ++i) {
    msg::ActuatorCommand& out = limb_[i].loan();
    out.stamp = measured_;
    out.count = plant::kKidLimbJoints[i];
    out.armed = moves ? 1 : 0;
    for (std::size_t c = 0; c < limbs_.joints[i].size(); ++c) out.value[c] = targets_[limbs_.joints[i][c]];
  }
  msg::GaitState& gait = gait_.loan();
  gait.stamp = measured_;
  gait.mode_since = since_;
  gait.q_world_torso = walk_->q_world_torso().to<msg::Quat>();
  gait.gyro_radps = walk_->tilt.rate_radps().to<msg::Vec3>();
  gait.x_m = walk_->odometry().at_m.x;
  gait.y_m = walk_->odometry().at_m.y;
  gait.height_m = height_m_;
  gait.heading_rad = walk_->odometry().yaw_rad;
  gait.forward_mps = walk_->speed().forward_mps;
  gait.left_mps = walk_->speed().left_mps;
  gait.turn_radps = walk_->speed().turn_radps;
  gait.error_x_m = walk_->dcm_error_m().x;
  gait.error_y_m = walk_->dcm_error_m().y;
  gait.mode = mode_;
  gait.support = walk_->support() == motion::Side::left ? 0 : 1;
  gait.steps = static_cast<std::uint32_t>(walk_->steps());
  gait.falls = falls_;
  gait.request = request_.id;
  gait.progress = progress_;
  gait.refused = refused_;
  gait.refusal = refusal_;
}

}  // namespace sinew::kid
