#include "control/head_law.hpp"

#include <algorithm>

#include "control/limits.hpp"

namespace sinew::control {
namespace {

using math::Quat;
using math::Vec3;
using msg::HeadMode;

Quat about_z(double rad) { return Quat::from_axis_angle({0, 0, 1}, rad); }
Quat about_y(double rad) { return Quat::from_axis_angle({0, 1, 0}, rad); }

/// So many times it turns round near the place of the loss: what hides a ball may do so for seconds.
constexpr std::uint32_t kStay = 8;

/// From `x` towards `to` by at most `step`.
double towards(double x, double to, double step) { return x + clamp(to - x, -step, step); }

}  // namespace

void HeadLaw::reset() {
  const HeadParams keep = params;
  const BallTrackParams keep_track = track.params;
  *this = {};
  params = keep;
  track.params = keep_track;
}

void HeadLaw::add(const msg::BallSighting& s) {
  last_picture_ = s.stamp;
  if (!s.found) return;
  const auto then = history_.at(s.stamp);
  if (!then) return;
  const Vec3 in_head = params.q_head_optical.rotate(Vec3(s.direction_optical));
  // A ball in full sight has a confidence of 0.8 and more; the middle of a half hidden ball is a guess.
  constexpr double kSure = 0.75;
  const double doubt = s.confidence < kSure ? s.angular_radius_rad * (kSure - s.confidence) : 0;
  track.add(s.stamp, then->q_world_base.rotate(in_head), doubt);
}

void HeadLaw::set_safety(const msg::SafetyState& safety) {
  permitted_ = safety.permitted;
  action_ = safety.action;
}

void HeadLaw::enter(HeadMode mode, msg::Time now) {
  if (state_.mode == mode) return;
  state_.mode = mode;
  state_.mode_since = now;
  if (mode == HeadMode::search) begin_search(now);
}

void HeadLaw::begin_search(msg::Time now) {
  scan_turns_ = 0;
  if (!track.exists()) {  // it can be anywhere
    scan_centre_ = {aim_.azimuth_rad, params.scan_elevation_rad};
    scan_swing_ = math::kPi;
    return;
  }
  // The ball comes out again where it went in, or where its speed was taking it.
  const BallTrack::Aim seen = track.at(track.stamp()), gone = track.at(now);
  const double way = math::wrap_pi(gone.azimuth_rad - seen.azimuth_rad);
  scan_centre_ = {math::wrap_pi(seen.azimuth_rad + 0.5 * way), 0.5 * (seen.elevation_rad + gone.elevation_rad)};
  scan_swing_ = std::max(0.5 * params.view_rad - 0.5 * math::fabs(way), 0.25 * params.view_rad);
  if (seen.azimuth_radps != 0) scan_side_ = seen.azimuth_radps > 0 ? 1 : -1;  // first in the ball's direction
}

void HeadLaw::search(double forward_rad, double dt_s) {
  const double from_centre = math::wrap_pi(aim_.azimuth_rad - scan_centre_.azimuth_rad);
  const double from_forward = math::wrap_pi(aim_.azimuth_rad - forward_rad);
  if (scan_side_ * from_centre > scan_swing_ || scan_side_ * from_forward > params.scan_reach_rad) {
    scan_side_ = -scan_side_;
    if (++scan_turns_ >= kStay && scan_turns_ % 2 == 0)
      scan_swing_ = clamp(scan_swing_ + params.view_rad, 0, math::kPi);
  }
  aim_.azimuth_rad = math::wrap_pi(aim_.azimuth_rad + scan_side_ * params.scan_radps * dt_s);
  const double elevation = scan_turns_ < kStay ? scan_centre_.elevation_rad : params.scan_elevation_rad;
  aim_.elevation_rad = towards(aim_.elevation_rad, elevation, params.turn_radps * dt_s);
}

void HeadLaw::choose_mode(msg::Time now) {
  armed_ = permitted_ != 0 && action_ != msg::FailsafeAction::stop;
  const double unseen_s = msg::seconds(now - track.stamp());
  if (!armed_)
    enter(HeadMode::idle, now);
  else if (action_ == msg::FailsafeAction::land || msg::seconds(now - last_picture_) > params.blind_s)
    enter(HeadMode::hold, now);
  else if (!track.exists() || unseen_s > params.coast_s)
    enter(HeadMode::search, now);
  else
    enter(unseen_s < 0.12 ? HeadMode::follow : HeadMode::coast, now);  // three pictures and their delay
}

/// Where to look at `at`; `forward_rad` is the azimuth of the base's x.
void HeadLaw::move_aim(msg::Time at, double forward_rad, double dt_s) {
  const double turn = params.turn_radps * dt_s;
  switch (state_.mode) {
    case HeadMode::idle:
      break;
    case HeadMode::follow:
    case HeadMode::coast: {
      const BallTrack::Aim ball = track.at(at);
      aim_ = {ball.azimuth_rad, ball.elevation_rad};
      state_.ball_azimuth_radps = ball.azimuth_radps;
      state_.ball_elevation_radps = ball.elevation_radps;
      break;
    }
    case HeadMode::search:
      search(forward_rad, dt_s);
      break;
    case HeadMode::hold: {
      const double side = math::wrap_pi(aim_.azimuth_rad - forward_rad);
      aim_.azimuth_rad = math::wrap_pi(forward_rad + towards(side, 0, turn));
      aim_.elevation_rad = towards(aim_.elevation_rad, 0, turn);
      break;
    }
  }
}

void HeadLaw::point(const Quat& q_level_base, double dt_s) {
  const math::SinCos az = math::sincos(aim_.azimuth_rad), el = math::sincos(aim_.elevation_rad);
  const Vec3 d = q_level_base.conjugate().rotate({el.cos * az.cos, el.cos * az.sin, el.sin});
  const double step = params.speed_radps * dt_s;
  if (params.tilt_most_rad <= math::kPi / 2) {
    const double pan = clamp(math::atan2(d.y, d.x), params.pan_least_rad, params.pan_most_rad);
    const double tilt = clamp(math::atan2(-d.z, math::hypot(d.x, d.y)), params.tilt_least_rad, params.tilt_most_rad);
    setpoint_ = {towards(setpoint_[0], pan, step), towards(setpoint_[1], tilt, step)};
    return;
  }
  // Straight below every pan is right: it goes back to straight ahead there, and takes part in the pointing the more
  // the ball is away from there.
  constexpr double kBelow = 0.1, kAway = 0.3;  // sines of the angle from straight down
  const double beside = math::hypot(d.x, d.y);
  const double share = d.z > 0 ? 1 : clamp((beside - kBelow) / (kAway - kBelow), 0, 1);
  double pan = math::atan2(d.y, d.x);
  const bool tilt_reaches = math::kPi / 2 + math::atan2(beside, -d.z) < params.tilt_most_rad;
  const bool behind = math::fabs(pan) > math::kPi / 2 && (share < 1 || tilt_reaches);
  if (behind) pan = math::wrap_pi(pan + math::kPi);  // tilt looks past straight down
  pan = clamp(share * pan, params.pan_least_rad, params.pan_most_rad);
  setpoint_[0] = towards(setpoint_[0], pan, step);
  // In the plane that pan has turned the head to, also past the vertical.
  const math::SinCos turned = math::sincos(setpoint_[0]);
  double ahead = d.x * turned.cos + d.y * turned.sin;
  if (share == 1 && !behind && ahead < 0) ahead = 0;
  const double tilt = clamp(math::atan2(-d.z, ahead), params.tilt_least_rad, params.tilt_most_rad);
  setpoint_[1] = towards(setpoint_[1], tilt, step);
}

void HeadLaw::take_joints(const msg::JointState& joints, double dt_s) {
  if (params.joints_lag_s > 0) return model_joints(joints, dt_s);
  const double passed_s = msg::seconds(joints.stamp - joint_stamp_);
  constexpr double kLongest_s = 0.5;  // between two positions that say something about the speed
  for (std::size_t i = 0; i < 2; ++i) {
    if (!math::is_nan(joints.velocity_radps[i]))
      joint_radps_[i] = joints.velocity_radps[i];
    else if (passed_s > 0)
      joint_radps_[i] = passed_s < kLongest_s ? (joints.position_rad[i] - joint_rad_[i]) / passed_s : 0;
    joint_rad_[i] = joints.position_rad[i];
  }
  joint_stamp_ = joints.stamp;
}

/// They follow their setpoints with a lag, and are corrected by what they tell.
void HeadLaw::model_joints(const msg::JointState& joints, double dt_s) {
  constexpr double kTrust = 0.5;  // in what they tell: it is as old as the link makes it
  const bool first = joint_stamp_.ns == 0, told = joints.stamp != joint_stamp_;
  joint_stamp_ = joints.stamp;
  for (std::size_t i = 0; i < 2; ++i) {
    if (first) joint_rad_[i] = joints.position_rad[i];
    joint_radps_[i] = 0;
    if (armed_)
      joint_radps_[i] =
          clamp((setpoint_[i] - joint_rad_[i]) / params.joints_lag_s, -params.speed_radps, params.speed_radps);
    joint_rad_[i] += dt_s * joint_radps_[i];
    if (told) joint_rad_[i] += kTrust * (joints.position_rad[i] - joint_rad_[i]);
  }
}

/// At the instant of the estimate.
HeadLaw::Pose HeadLaw::pose_by_head(const msg::NavState& nav, const msg::JointState& joints) const {
  const Quat q_level_head(nav.q_world_base);
  const double newer_s = msg::seconds(nav.stamp - joints.stamp);
  const double pan = joint_rad_[0] + joint_radps_[0] * newer_s;
  const double tilt = joint_rad_[1] + joint_radps_[1] * newer_s;
  const Quat q_base_yoke = about_z(pan), q_base_head = q_base_yoke * about_y(tilt);
  const Vec3 rate = q_base_head.rotate(Vec3(nav.gyro_radps)) - Vec3{0, 0, joint_radps_[0]} -
                    q_base_yoke.rotate({0, joint_radps_[1], 0});
  return {(q_level_head * q_base_head.conjugate()).normalized(), q_level_head, rate, pan, tilt};
}

/// Now: estimate and joints, each carried on from its own instant.
HeadLaw::Pose HeadLaw::pose_by_base(msg::Time now, const msg::NavState& nav, const msg::JointState& joints) const {
  constexpr double kLongest_s = 0.2;  // that a motion is carried on
  const double base_s = clamp(msg::seconds(now - nav.stamp), 0, kLongest_s);
  const double joints_s = params.joints_lag_s > 0 ? 0 : clamp(msg::seconds(now - joints.stamp), 0, kLongest_s);
  const Vec3 rate(nav.gyro_radps);
  const Quat q_level_base = (Quat(nav.q_world_base) * Quat::exp(rate * base_s)).normalized();
  const double pan = clamp(joint_rad_[0] + joint_radps_[0] * joints_s, params.pan_least_rad, params.pan_most_rad);
  const double tilt = clamp(joint_rad_[1] + joint_radps_[1] * joints_s, params.tilt_least_rad, params.tilt_most_rad);
  return {q_level_base, (q_level_base * about_z(pan) * about_y(tilt)).normalized(), rate, pan, tilt};
}

void HeadLaw::step(msg::Time now, const msg::NavState& nav, const msg::JointState& joints, double dt_s) {
  take_joints(joints, dt_s);
  const Pose pose = params.imu_on_base != 0 ? pose_by_base(now, nav, joints) : pose_by_head(nav, joints);
  const msg::Time at = params.imu_on_base != 0 ? now : nav.stamp;
  history_.add({at, {}, pose.q_level_head});
  base_rate_radps_ += (dt_s / (params.rate_smooth_s + dt_s)) * (pose.base_rate_radps - base_rate_radps_);

  if (last_picture_.ns == 0) last_picture_ = now;  // none yet: the first one may take a moment
  choose_mode(now);
  const double ahead_s = msg::seconds(now - at) + params.lag_s;
  const Quat q_then = (pose.q_level_base * Quat::exp(base_rate_radps_ * ahead_s)).normalized();
  const Vec3 axis = pose.q_level_head.rotate({1, 0, 0}), up = pose.q_level_base.rotate({0, 0, 1});
  if (!armed_) {  // begins where it stands
    aim_ = {math::atan2(axis.y, axis.x), math::atan2(axis.z, math::hypot(axis.x, axis.y))};
    setpoint_ = {clamp(pose.pan_rad, params.pan_least_rad, params.pan_most_rad),
                 clamp(pose.tilt_rad, params.tilt_least_rad, params.tilt_most_rad)};
  } else {
    const Vec3 forward = q_then.rotate({1, 0, 0});
    move_aim(now + msg::Duration{static_cast<std::int64_t>(1e9 * params.lag_s)}, math::atan2(forward.y, forward.x),
             dt_s);
    point(q_then, dt_s);
  }
  state_.stamp = nav.stamp;
  state_.azimuth_rad = aim_.azimuth_rad;
  state_.elevation_rad = aim_.elevation_rad;
  state_.axis_elevation_rad = math::atan2(axis.z, math::hypot(axis.x, axis.y));
  state_.base_tilt_rad = math::atan2(math::hypot(up.x, up.y), up.z);
  state_.innovation_rad = track.innovation_rad();
  state_.sightings = track.used();
}

}  // namespace sinew::control
