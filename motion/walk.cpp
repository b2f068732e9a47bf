#include "motion/walk.hpp"

#include <algorithm>

#include "motion/posture.hpp"

namespace sinew::motion {
namespace {

constexpr double kCellInset_m = 0.01;
constexpr double kShiftMost_s = 0.4;
constexpr double kMostError_m = 0.15;  // of the dcm: more is a fall, or a wrong measurement
constexpr double kMostBias_m = 0.03;
constexpr double kSink_mps = 0.05;

double outside(double x, double dead) { return x > dead ? x - dead : (x < -dead ? x + dead : 0); }

}  // namespace

Walk::Walk(const Figure& figure, std::span<const double> rest_rad) : figure_(&figure), sense_(figure), lead_(figure) {
  std::copy_n(rest_rad.begin(), std::min(rest_rad.size(), figure.joints()), rest_rad_.begin());
}

void Walk::reset(const Sensed& sensed) {
  tilt.start(sensed.accel_mps2);
  q_now_ = tilt.q_world_torso();
  odometry_ = {{0, 0}, q_now_.yaw()};
  begin_plan(sensed);
}

void Walk::take_over(const Sensed& sensed) { begin_plan(sensed); }

void Walk::sense_only(const Sensed& sensed, double dt_s) {
  sense(sensed, dt_s);
  odometry_.yaw_rad = q_now_.yaw();
}

void Walk::begin_plan(const Sensed& sensed) {
  const TorsoOffsets offsets = torso_offsets(*figure_, params, rest_rad_);
  com_in_torso_ = offsets.com_m;
  torso_over_hips_m_ = offsets.over_hips_m;
  sense_.step(sensed, q_now_, kCellInset_m);
  phase_ = WalkPhase::stand;
  support_ = Side::right;
  speed_ = next_speed_ = {};
  kicking_ = wants_kick_ = prepares_ = false;
  steps_ = stopping_ = 0;
  time_s_ = touch_s_ = 0;
  foot_ = landing_ = lifted_ = {{0, params.stance_m}, 0};
  foot_z_m_ = lifted_z_m_ = support_z_m_ = support_z0_m_ = 0;
  yaw0_rad_ = 0;
  plan_ = {};
  plan_.x.com_m = plan_.x.dcm_m = params.com_forward_m;
  plan_.y.com_m = plan_.y.dcm_m = 0.5 * params.stance_m;
  carried_ = {0.5, 0.5};
  frame_yaw_rad_ = heading_rad_ = 0;
  past_ = {};
  newest_ = 0;
  seeing_ = false;
  error_m_ = {};
  bias_m_ = {};
  rate_ = {};
  lead_.reset();
  heading_rad_ = odometry_.yaw_rad = q_now_.yaw();
  anchor_ = odometry_ * stance().torso[index(Side::right)].inverse();
}

double Walk::wanted_distance() const {
  return params.stance_m + params.turn_stance_m_per_radps * math::fabs(speed_.turn_radps);
}

void Walk::step(const WalkCommand& command, const Sensed& sensed, double dt_s, std::span<double> targets_rad) {
  dt_s_ = dt_s;
  command_ = command;
  sense(sensed, dt_s);
  observe(dt_s);
  correct(dt_s);
  switch (phase_) {
    case WalkPhase::stand:
      stand(dt_s);
      break;
    case WalkPhase::shift:
      shift(dt_s);
      break;
    case WalkPhase::step:
      advance_step(dt_s);
      break;
  }
  remember();
  write(dt_s, targets_rad);
}

void Walk::sense(const Sensed& sensed, double dt_s) {
  const bool at_rest = phase_ == WalkPhase::stand && time_s_ > params.settle_s;
  tilt.step(sensed.gyro_radps, sensed.accel_mps2, at_rest, dt_s);
  q_now_ = tilt.q_world_torso() * math::Quat::exp(tilt.rate_radps() * params.imu_late_s);
  rate_ += (tilt.rate_radps() - rate_) * (dt_s / (dt_s + params.gyro_smooth_s));
  sense_.step(sensed, q_now_, kCellInset_m);
}

const Walk::Past& Walk::past(double age_s) const {
  const auto back = std::min(kPast - 1, static_cast<std::size_t>(math::round(age_s / dt_s_)));
  return past_[(newest_ + kPast - back) % kPast];
}

void Walk::remember() {
  newest_ = (newest_ + 1) % kPast;
  past_[newest_] = {plan_, frame_yaw_rad_, support_, 1};
}

/// The pendulum over the sole that carried when what is measured now was caused: position from the chain, speed from
/// where the soles are pressed.
void Walk::observe(double dt_s) {
  const Past& then = past(params.late_s);
  const Side side = then.valid ? then.support : support_;
  const Stance& s = stance();
  const std::size_t i = index(side), o = index(other(side));
  const Vec2 com{s.com_m[i].x, s.com_m[i].y};
  if (seeing_ && side != seen_support_) {  // the same pendulum, from the other sole
    const Planar to_new = s.to_other(seen_support_).inverse();
    const Vec2 c = to_new.of({seen_.x.com_m, seen_.y.com_m}), d = to_new.of({seen_.x.dcm_m, seen_.y.dcm_m});
    seen_.x = {c.x, d.x};
    seen_.y = {c.y, d.y};
    anchor_ = anchor_ * s.to_other(seen_support_);
  }
  if (!seeing_) {
    seen_.x = {com.x, com.x};
    seen_.y = {com.y, com.y};
  }
  seen_support_ = side;
  seeing_ = true;

  const double total = s.load[0] + s.load[1];
  Vec2 cop{seen_.x.com_m, seen_.y.com_m};  // in the air nothing pushes
  if (total > 0.1) {
    const Vec2 far = s.to_other(side).of(s.cop_m[o]);
    cop = (s.load[i] / total) * s.cop_m[i] + (s.load[o] / total) * far;
  }
  const auto along = [&](Pendulum& p, double at_m, double cop_m) {
    double com_m = p.com_m, speed = p.speed_mps(params.omega_radps);
    speed += params.omega_radps * params.omega_radps * (com_m - cop_m) * dt_s;
    com_m += speed * dt_s;
    const double error = at_m - com_m;
    com_m += params.observer_share * error;
    speed += params.observer_per_s * error;
    p = {com_m, com_m + speed / params.omega_radps};
  };
  along(seen_.x, com.x, cop.x);
  along(seen_.y, com.y, cop.y);

  anchor_.yaw_rad = q_now_.yaw() - s.torso[i].yaw_rad;
  odometry_ = anchor_ * s.torso[i];
}

/// Draws the plan to the measured pendulum, and what is remembered of the plan with it: so an error is answered once.
void Walk::correct(double dt_s) {
  const Past& then = past(params.late_s);
  error_m_ = {};
  if (!then.valid || phase_ != WalkPhase::step) return;
  Vec2& bias = bias_m_[index(then.support)];
  const Vec2 raw{seen_.x.dcm_m - then.plan.x.dcm_m, seen_.y.dcm_m - then.plan.y.dcm_m};
  const double learn = dt_s / params.bias_s;
  bias = {std::clamp(bias.x + learn * (raw.x - bias.x), -kMostBias_m, kMostBias_m),
          std::clamp(bias.y + learn * (raw.y - bias.y), -kMostBias_m, kMostBias_m)};
  const auto limited = [&](double e) { return std::clamp(outside(e, params.dcm_dead_m), -kMostError_m, kMostError_m); };
  const Vec2 dcm_there{limited(raw.x - bias.x), limited(raw.y - bias.y)};
  const Vec2 com_there{seen_.x.com_m - then.plan.x.com_m, seen_.y.com_m - then.plan.y.com_m};
  error_m_ = turned(dcm_there, then.yaw_rad - frame_yaw_rad_);
  const double fast = params.dcm_per_s + params.dcm_more_per_sm * norm(error_m_);
  const double take = std::min(1.0, fast * dt_s), take_com = std::min(1.0, params.com_per_s * dt_s);
  const double grown = math::exp(params.omega_radps * params.late_s);
  const Vec2 com = turned(com_there, then.yaw_rad - frame_yaw_rad_);
  const double cos = math::cos(then.yaw_rad - frame_yaw_rad_);
  for (Past& p : past_) {  // frames of past steps are turned by little
    p.plan.x.dcm_m += take * error_m_.x * cos;
    p.plan.y.dcm_m += take * error_m_.y * cos;
  }
  plan_.x.dcm_m += take * grown * error_m_.x;
  plan_.y.dcm_m += take * grown * error_m_.y;
  plan_.x.com_m += take_com * com.x;
  plan_.y.com_m += take_com * com.y;
}

/// Both soles on the ground: the ground may push anywhere between them.
void Walk::stand(double dt_s) {
  const Vec2 middle{0.5 * foot_.at_m.x + params.com_forward_m, 0.5 * foot_.at_m.y};
  const double strength = 1.6;
  const auto along = [&](Pendulum& p, double rest_m, double least_m, double most_m) {
    const double cop = std::clamp(rest_m + strength * (p.dcm_m - rest_m), least_m, most_m);
    p = p.later(cop, params.omega_radps, dt_s);
    return cop;
  };
  const double x = params.cop_most_x_m;
  cop_m_.x = along(plan_.x, middle.x, std::min(0.0, foot_.at_m.x) - x, std::max(0.0, foot_.at_m.x) + x);
  const double y0 = std::min(0.0, foot_.at_m.y), y1 = std::max(0.0, foot_.at_m.y);
  cop_m_.y = along(plan_.y, middle.y, y0, y1);
  plan_.x.com_m = std::clamp(plan_.x.com_m, middle.x - 0.1, middle.x + 0.1);
  plan_.x.dcm_m = std::clamp(plan_.x.dcm_m, middle.x - 0.1, middle.x + 0.1);
  plan_.y.com_m = std::clamp(plan_.y.com_m, y0, y1);
  plan_.y.dcm_m = std::clamp(plan_.y.dcm_m, y0, y1);
  yaw0_rad_ += std::clamp(0.5 * foot_.yaw_rad - yaw0_rad_, -dt_s, dt_s);
  foot_z_m_ = std::max(0.0, foot_z_m_ - kSink_mps * dt_s);
  support_z_m_ = std::max(0.0, support_z_m_ - kSink_mps * dt_s);
  time_s_ += dt_s;
  speed_ = {};
  if (!command_.walk || time_s_ < params.settle_s) return;
  // The first foot to swing is that of the side that the walk goes to.
  const double to = math::fabs(command_.left_mps) > 0.02 ? command_.left_mps : command_.turn_radps;
  const Side first = to >= 0 ? Side::left : Side::right;
  if (support_ == first) change_support(foot_);
  heading_rad_ = q_now_.yaw();
  phase_ = WalkPhase::shift;
  time_s_ = 0;
  stopping_ = 0;
}

void Walk::shift(double dt_s) {
  speed_ = {};
  const double toward = sign(other(support_));
  const double begin = toward * (params.cop_inside_m + steady_dcm(params.stance_m - 2 * params.cop_inside_m,
                                                                  params.stance_m - 2 * params.cop_inside_m,
                                                                  params.omega_radps, period()));
  cop_m_ = {plan_.x.dcm_m + 0.6 * (plan_.x.dcm_m - params.com_forward_m), foot_.at_m.y - toward * params.cop_inside_m};
  plan_.x = plan_.x.later(cop_m_.x, params.omega_radps, dt_s);
  plan_.y = plan_.y.later(cop_m_.y, params.omega_radps, dt_s);
  time_s_ += dt_s;
  if (toward * (plan_.y.dcm_m - begin) <= 0 || time_s_ > kShiftMost_s) begin_step();
}

}  // namespace sinew::motion
