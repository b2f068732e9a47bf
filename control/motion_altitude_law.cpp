#include "control/motion_altitude_law.hpp"

#include "control/inertial_filter.hpp"
#include "control/limits.hpp"

namespace sinew::control {

using msg::AltitudePhase;

void MotionAltitudeLaw::reset() {
  const MotionAltitudeParams keep = params;
  *this = MotionAltitudeLaw{};
  params = keep;
}

/// m f = -(k1 v + k2 v |v|), solved for v.
double MotionAltitudeLaw::airspeed_of(double force_mps2, const MotionAltitudeParams& p) {
  const double drag_n = math::fabs(force_mps2) * p.mass_kg, k1 = p.drag_n_per_mps, k2 = p.drag_n_per_m2ps2;
  const double v = k2 > 0 ? (math::sqrt(k1 * k1 + 4 * k2 * drag_n) - k1) / (2 * k2) : drag_n / k1;
  return force_mps2 < 0 ? v : -v;
}

/// On level ground, at rest: whatever the accelerometer says beside gravity along base z is its error.
void MotionAltitudeLaw::learn_zero(const Input& in, double dt_s) {
  zero_sum_ += in.force_mps2 * dt_s;
  zero_s_ += dt_s;
  zero_mps2_ = zero_sum_ / zero_s_ - math::Vec3{0, 0, kGravity};
  yaw_rad_ = math::Quat(in.nav.q_world_base).yaw();
}

void MotionAltitudeLaw::take_height(double height_m, double since_s) {
  const double most = params.most_height_share * nominal_m(), least = params.least_height_share * nominal_m();
  // Steps of the ground are smaller: what differs by more is a wrong motion in part.
  const double step_m = params.most_step_share * nominal_m();
  const double off = clamp(clamp(height_m, least, most) - state_.height_m, -step_m, step_m);
  const double w = params.observer_radps, dt_s = clamp(since_s, 0, 0.1);
  state_.height_m += 1.4 * w * dt_s * off;
  state_.climb_mps += w * w * dt_s * off;
  height_age_s_ = 0;
}

void MotionAltitudeLaw::take_motion(const msg::GroundMotion& motion) {
  state_.motion_radps = motion.forward_radps;
  const double blend = motion_age_s_ / (params.drift_time_s + motion_age_s_);
  drift_mps_ += blend * (motion.left_radps * nominal_m() - drift_mps_);
  motion_age_s_ = 0;
}

void MotionAltitudeLaw::observe(const Input& in, double dt_s) {
  const math::Vec3 force = in.force_mps2 - zero_mps2_;
  const double blend = dt_s / (params.airspeed_time_s + dt_s);
  drag_x_mps2_ += blend * (force.x - drag_x_mps2_);
  drag_y_mps2_ += blend * (force.y - drag_y_mps2_);
  state_.airspeed_mps = airspeed_of(drag_x_mps2_, params);
  state_.airspeed_left_mps = airspeed_of(drag_y_mps2_, params);

  state_.climb_mps += dt_s * (math::Quat(in.nav.q_world_base).rotate(force).z - kGravity);
  state_.height_m += dt_s * state_.climb_mps;
  motion_age_s_ += dt_s;
  height_age_s_ += dt_s;
  const double since_s = height_age_s_;
  if (in.motion != nullptr && in.motion->seen != 0) {
    take_motion(*in.motion);
    const double least_radps = params.speed_mps / (params.most_height_share * nominal_m());
    if (state_.phase == AltitudePhase::follow && !in.by_range)
      take_height(params.speed_mps / (in.motion->forward_radps > least_radps ? in.motion->forward_radps : least_radps) +
                      params.camera_m,
                  since_s);
  }
  if (state_.phase == AltitudePhase::follow && in.by_range && in.range_m > 0)
    take_height(in.range_m * math::Quat(in.nav.q_world_base).rotate({0, 0, 1}).z + params.camera_m, since_s);
  state_.motion_fresh = motion_age_s_ < params.motion_lost_s;
}

/// The thrust along world z that the height asks for.
double MotionAltitudeLaw::vertical(double dt_s) {
  const MotionAltitudeParams& p = params;
  double climb_mps = 0, away_m = 0;
  if (state_.phase == AltitudePhase::climb || state_.phase == AltitudePhase::speed_up) {
    const double left_m = nominal_m() - wanted_m_;
    climb_mps = clamp(left_m, 0, p.climb_mps);
    wanted_m_ += climb_mps * dt_s;
    away_m = wanted_m_ - state_.height_m;
  } else if (height_age_s_ < p.motion_lost_s) {
    away_m = nominal_m() - state_.height_m;
  }
  // A wrong motion for a moment must not make it dive: what it may sink and climb is limited.
  climb_mps = clamp(climb_mps + p.kp_height / p.kd_height * away_m, -p.most_sink_mps, p.most_climb_mps);
  const double wish = p.kd_height * (climb_mps - state_.climb_mps);
  const double unlimited = p.mass_kg * (kGravity + wish + lift_integral_mps2_);
  const double thrust = clamp(unlimited, p.thrust_min_n, p.thrust_max_n);
  if (thrust == unlimited)
    lift_integral_mps2_ =
        clamp(lift_integral_mps2_ + p.ki_height * wish / p.kd_height * dt_s, -p.integral_mps2, p.integral_mps2);
  return thrust;
}

void MotionAltitudeLaw::fly(const Input& in, double dt_s) {
  const MotionAltitudeParams& p = params;
  const bool forward = state_.phase == AltitudePhase::speed_up || state_.phase == AltitudePhase::follow;
  const double target_mps = forward ? p.speed_mps : 0;
  const double gain_mps = clamp(target_mps - wanted_mps_, -p.accel_mps2 * dt_s, p.accel_mps2 * dt_s);
  wanted_mps_ += gain_mps;
  const double drag_n = wanted_mps_ * (p.drag_n_per_mps + p.drag_n_per_m2ps2 * wanted_mps_);
  const double off_mps = wanted_mps_ - state_.airspeed_mps;
  // While the vehicle rises, its camera is too near to the ground to see a motion to the side.
  const bool sees = forward && state_.motion_fresh != 0;
  const double drift = sees ? drift_mps_ : state_.airspeed_left_mps;
  const double limit = p.tilt_rad;
  // Pitch is learned at a steady speed only: while it speeds up, the airspeed lags behind by its low pass.
  if (forward && gain_mps == 0 && math::fabs(off_mps) < 0.2 * p.speed_mps)
    pitch_integral_rad_ = clamp(pitch_integral_rad_ + p.ki_speed * off_mps * dt_s, -limit, limit);
  if (forward) roll_integral_rad_ = clamp(roll_integral_rad_ + p.ki_drift * drift * dt_s, -limit, limit);
  const double push_n = drag_n + p.mass_kg * gain_mps / dt_s;
  state_.pitch_rad =
      clamp(math::atan(push_n / (p.mass_kg * kGravity)) + p.kp_speed * off_mps + pitch_integral_rad_, -limit, limit);
  state_.roll_rad = clamp(p.kp_drift * drift + roll_integral_rad_, -limit, limit);  // > 0: to the right
  const math::Quat wanted = math::Quat::from_axis_angle({0, 0, 1}, yaw_rad_) *
                            math::Quat::from_axis_angle({0, 1, 0}, state_.pitch_rad) *
                            math::Quat::from_axis_angle({1, 0, 0}, state_.roll_rad);
  const double up = math::Quat(in.nav.q_world_base).rotate({0, 0, 1}).z;
  state_.thrust_n = clamp(vertical(dt_s) / clamp(up, 0.5, 1), p.thrust_min_n, p.thrust_max_n);
  setpoint_.q_world_base = wanted.to<msg::Quat>();
  setpoint_.thrust_n = state_.thrust_n;
  setpoint_.armed = 1;
}

void MotionAltitudeLaw::stand(const Input& in, double thrust_n, bool armed) {
  const double yaw = armed ? yaw_rad_ : math::Quat(in.nav.q_world_base).yaw();
  setpoint_.q_world_base = math::Quat::from_axis_angle({0, 0, 1}, yaw).to<msg::Quat>();
  setpoint_.thrust_n = state_.thrust_n = thrust_n;
  setpoint_.armed = armed;
  state_.pitch_rad = state_.roll_rad = 0;
}

void MotionAltitudeLaw::run_phase(const Input& in, double dt_s) {
  const bool flies = state_.phase == AltitudePhase::climb || state_.phase == AltitudePhase::speed_up ||
                     state_.phase == AltitudePhase::follow;
  if (state_.phase != AltitudePhase::wait && !in.permitted) enter(AltitudePhase::done);
  if (flies && in.action == msg::FailsafeAction::land) enter(AltitudePhase::land);
  in_phase_s_ += dt_s;
  switch (state_.phase) {
    case AltitudePhase::wait:
      if (in.nav.attitude_valid)
        learn_zero(in, dt_s);
      else
        zero_s_ = 0, zero_sum_ = {};
      if (zero_s_ >= params.settle_s && in.permitted && in.action == msg::FailsafeAction::none)
        enter(AltitudePhase::spin_up);
      return;
    case AltitudePhase::spin_up:
      state_.height_m = wanted_m_ = params.feet_below_base_m;
      state_.climb_mps = 0;
      if (in_phase_s_ >= params.spin_up_s) enter(AltitudePhase::climb);
      return;
    case AltitudePhase::climb:
      // Where it should hang still: most of the way, and what is left is climbed while it speeds up.
      if (wanted_m_ > 0.85 * nominal_m()) enter(AltitudePhase::speed_up);
      return;
    case AltitudePhase::speed_up:
      if (state_.airspeed_mps >= params.follow_share * params.speed_mps && state_.motion_fresh != 0) {
        height_age_s_ = 0;
        enter(AltitudePhase::follow);
      }
      return;
    case AltitudePhase::land:
      if (in_phase_s_ >= params.sink_s) enter(AltitudePhase::done);
      return;
    case AltitudePhase::follow:
    case AltitudePhase::done:
      return;
  }
}

void MotionAltitudeLaw::step(const Input& in, msg::Time now, double dt_s) {
  observe(in, dt_s);
  run_phase(in, dt_s);
  setpoint_.stamp = in.nav.stamp;
  state_.stamp = now;
  state_.wanted_motion_radps = params.wanted_motion_radps;
  switch (state_.phase) {
    case AltitudePhase::wait:
    case AltitudePhase::done:
      return stand(in, 0, false);
    case AltitudePhase::spin_up:
      return stand(in, 0, true);
    case AltitudePhase::land:
      return stand(in, params.sink_thrust_share * params.mass_kg * (kGravity + lift_integral_mps2_), true);
    default:
      return fly(in, dt_s);
  }
}

}  // namespace sinew::control
