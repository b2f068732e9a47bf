#include "robots/quad/mission_plan.hpp"

#include "control/limits.hpp"

namespace sinew::control {
namespace {

using msg::MissionPhase;

double horizontal(const math::Vec3& v) { return math::sqrt(v.x * v.x + v.y * v.y); }

/// Speed towards something `away` that can still be braked with `accel`.
double approach_speed(double away, double speed, double accel) {
  const double braked = math::sqrt(2 * accel * away);
  return braked < speed ? braked : speed;
}

/// Corner `leg` of a square spiral around the origin: (1,0) (1,1) (-1,1) (-1,-1) (2,-1) (2,2) (-2,2) ...
math::Vec3 spiral_corner(std::int64_t leg) {
  const double ring = static_cast<double>(leg / 4 + 1);
  switch (leg % 4) {
    case 0:
      return {ring, -(ring - 1), 0};
    case 1:
      return {ring, ring, 0};
    case 2:
      return {-ring, ring, 0};
    default:
      return {-ring, -ring, 0};
  }
}

}  // namespace

void MissionPlan::reset() {
  const MissionParams keep = params;
  *this = MissionPlan{};
  params = keep;
}

void MissionPlan::enter(MissionPhase phase, msg::Time now) {
  state_.phase = phase;
  state_.phase_since = now;
  touch_s_ = stuck_s_ = arrived_s_ = 0;
  if (phase == MissionPhase::done) setpoint_ = {};
}

bool MissionPlan::flying() const {
  return state_.phase >= MissionPhase::climb && state_.phase <= MissionPhase::descend;
}

bool MissionPlan::pad_fresh(const msg::NavState& nav) const {
  return nav.pad_known && msg::seconds(nav.stamp - nav.pad_stamp) < params.pad_lost_s;
}

bool MissionPlan::arrived(const msg::NavState& nav) const {
  const math::Vec3 away = target_m_ - math::Vec3(nav.p_world_m);
  return horizontal(away) < params.arrived_m && math::fabs(away.z) < 2 * params.arrived_m &&
         norm(math::Vec3(nav.v_world_mps)) < params.arrived_mps;
}

bool MissionPlan::touched(const msg::NavState& nav, double dt_s) {
  const double low_m = params.feet_below_base_m + params.touch_margin_m;
  // Without the range finder the height may be off by more than a vehicle survives: then only missing descent counts.
  const bool low = nav.ground_seen && nav.height_m < low_m;
  const bool slow = math::fabs(nav.v_world_mps.z) < params.touch_mps;
  touch_s_ = low && slow ? touch_s_ + dt_s : 0;
  // Most of the time, not all: on uneven ground the vehicle rocks. On the ground the estimate may even rise.
  const bool stuck = setpoint_.v_world_mps.z < -2 * params.stuck_mps && nav.v_world_mps.z > -params.stuck_mps;
  stuck_s_ = stuck ? stuck_s_ + dt_s : clamp(stuck_s_ - dt_s, 0, stuck_s_);
  // After an abort in the climb the vehicle floats for seconds before it sinks; stopping it there would drop it.
  const bool high = nav.ground_seen && nav.height_m > low_m + params.touch_margin_m;
  return touch_s_ >= params.touch_s || stuck_s_ >= (high ? params.stuck_high_s : params.stuck_s);
}

void MissionPlan::step(msg::Time now, const msg::NavState& nav, double dt_s) {
  if (begun_ == 0) {
    begun_ = 1;
    enter(MissionPhase::wait, now);
  }
  obey(now);
  const bool valid = nav.attitude_valid && nav.position_valid;
  valid_s_ = valid ? valid_s_ + dt_s : 0;
  invalid_s_ = valid ? 0 : invalid_s_ + dt_s;
  const bool falls = nav.height_valid && nav.v_world_mps.z < -params.fall_mps;
  const bool late = msg::seconds(now - armed_at_) > params.timeout_s ||
                    (state_.phase == MissionPhase::climb && in_phase_s(now) > params.climb_limit_s);
  if (flying() && (invalid_s_ > params.estimate_lost_s || falls || late)) enter(MissionPhase::abort, now);
  setpoint_ = {};
  setpoint_.yaw_rad = yaw_rad_;
  run_phase(now, nav, dt_s);
  setpoint_.stamp = nav.stamp;
  state_.stamp = nav.stamp;
  state_.pad_known = nav.pad_known;
  state_.target_world_m = target_m_.to<msg::Vec3>();
}

void MissionPlan::stand_by(msg::Time now, const msg::NavState& nav) {
  obey(now);
  const bool air = flying() || state_.phase == MissionPhase::touchdown || state_.phase == MissionPhase::abort;
  if (air) enter(MissionPhase::abort, now);  // again each time, so that its times count from the handing back
  if (state_.phase == MissionPhase::arm) enter(MissionPhase::wait, now);
  valid_s_ = invalid_s_ = 0;
  setpoint_ = {};
  setpoint_.stamp = nav.stamp;
  setpoint_.yaw_rad = yaw_rad_ = math::Quat(nav.q_world_base).yaw();
  setpoint_.v_world_mps = nav.v_world_mps;  // no error, so nothing winds up below
  setpoint_.p_world_m = nav.p_world_m;
  setpoint_.mode = air ? msg::FlightMode::velocity : msg::FlightMode::idle;
  setpoint_.armed = air ? 1 : 0;
  state_.stamp = nav.stamp;
  state_.pad_known = nav.pad_known;
}

void MissionPlan::obey(msg::Time now) {
  const bool stopped = safety_.permitted == 0 || safety_.action == msg::FailsafeAction::stop;
  const bool calm = !stopped && safety_.action == msg::FailsafeAction::none;
  if (state_.phase == MissionPhase::arm && !calm) return enter(MissionPhase::wait, now);
  const bool armed = flying() || state_.phase == MissionPhase::touchdown || state_.phase == MissionPhase::abort;
  if (armed && stopped) return enter(MissionPhase::done, now);
  if (flying() && !calm) enter(MissionPhase::abort, now);
}

void MissionPlan::run_phase(msg::Time now, const msg::NavState& nav, double dt_s) {
  switch (state_.phase) {
    case MissionPhase::wait:
      if (valid_s_ >= params.settle_s && waits_ == 0 && safety_.permitted != 0 &&
          safety_.action == msg::FailsafeAction::none)
        enter(MissionPhase::arm, now);
      break;
    case MissionPhase::arm:
      setpoint_.armed = 1;
      if (valid_s_ < params.settle_s) return enter(MissionPhase::wait, now);
      if (in_phase_s(now) < params.spin_up_s) break;
      armed_at_ = now;
      yaw_rad_ = math::Quat(nav.q_world_base).yaw();
      reference_m_ = search_centre_m_ = math::Vec3(nav.p_world_m);
      reference_mps_ = {};
      target_m_ = {reference_m_.x, reference_m_.y, reference_m_.z - nav.height_m + params.search_height_m};
      enter(MissionPhase::climb, now);
      break;
    case MissionPhase::climb:
      slew(dt_s);
      fly_reference();
      if (nav.height_m > params.search_height_m - 0.15) {
        search_leg_ = 0;
        if (told_) {
          search_centre_m_ = told_pad_m_;
          target_m_.x = told_pad_m_.x;
          target_m_.y = told_pad_m_.y;
        }
        enter(MissionPhase::search, now);
      }
      break;
    case MissionPhase::search:
      run_search(now, nav, dt_s);
      break;
    case MissionPhase::approach:
    case MissionPhase::hold:
      target_m_ = above_landing(nav);
      slew(dt_s);
      fly_reference();
      if (!pad_fresh(nav) && horizontal(target_m_ - math::Vec3(nav.p_world_m)) < 0.5) return lose_pad(now);
      if (state_.phase == MissionPhase::approach) {
        if (arrived(nav)) enter(MissionPhase::hold, now);
      } else {
        arrived_s_ = arrived(nav) ? arrived_s_ + dt_s : 0;
        // A vehicle that does not settle in that time never will; the descent itself pauses while it is off the pad.
        if (arrived_s_ >= params.hold_s || in_phase_s(now) > params.hold_limit_s) enter(MissionPhase::descend, now);
      }
      break;
    case MissionPhase::descend:
      run_descend(now, nav, dt_s);
      break;
    case MissionPhase::touchdown:
      setpoint_.armed = 1;
      if (in_phase_s(now) > 0.3) enter(MissionPhase::done, now);
      break;
    case MissionPhase::abort:
      run_abort(now, nav, dt_s);
      break;
    case MissionPhase::done:
      break;
  }
}

math::Vec3 MissionPlan::above_landing(const msg::NavState& nav) const {
  return {nav.pad_world_m.x + params.land_x_m, nav.pad_world_m.y + params.land_y_m,
          nav.pad_world_m.z + params.approach_height_m};
}

void MissionPlan::run_search(msg::Time now, const msg::NavState& nav, double dt_s) {
  slew(dt_s);
  fly_reference();
  if (in_phase_s(now) < params.look_s) return;
  if (pad_fresh(nav)) return enter(guided_ ? MissionPhase::descend : MissionPhase::approach, now);
  const math::Vec3 away = target_m_ - reference_m_;
  if (horizontal(away) > 0.05 || math::fabs(away.z) > 0.05) return;
  const math::Vec3 corner = spiral_corner(search_leg_++) * params.search_spacing_m;
  if (math::fabs(corner.x) > params.search_radius_m) return lose_pad(now);  // all seen: once more from the start
  target_m_.x = search_centre_m_.x + corner.x;
  target_m_.y = search_centre_m_.y + corner.y;
}

/// If the ground is felt long before the height says so, the camera sees no pad: another climb would not help.
bool MissionPlan::committed(const msg::NavState& nav) const {
  return nav.height_m < params.commit_below_m || stuck_s_ >= params.felt_s;
}

void MissionPlan::run_guided(msg::Time now, const msg::NavState& nav, double dt_s) {
  target_m_ = above_landing(nav);
  reference_m_ = math::Vec3(nav.p_world_m);  // from where it goes on, should the pad be lost
  const bool committed_now = committed(nav);
  if (!committed_now && !pad_fresh(nav)) return lose_pad(now);
  math::Vec3 v = guide_mps_;
  if (guide_silent_ && committed_now) v.z = -params.sink_slow_mps;
  reference_mps_ = v;
  setpoint_.armed = 1;
  setpoint_.mode = msg::FlightMode::velocity;
  setpoint_.v_world_mps = v.to<msg::Vec3>();
  if (touched(nav, dt_s)) enter(MissionPhase::touchdown, now);
}

void MissionPlan::run_descend(msg::Time now, const msg::NavState& nav, double dt_s) {
  if (guided_) return run_guided(now, nav, dt_s);
  target_m_ = above_landing(nav);
  target_m_.z = reference_m_.z;  // the height is led below, not by slew()
  reference_mps_.z = 0;
  slew(dt_s);
  const double height = nav.height_m;
  const bool committed_now = committed(nav);
  if (!committed_now && !pad_fresh(nav)) return lose_pad(now);

  const double off = horizontal(target_m_ - math::Vec3(nav.p_world_m));
  const double sink = height > params.slow_below_m ? params.sink_fast_mps : params.sink_slow_mps;
  const bool centred = off < params.centred_m + params.centred_per_m * height;
  const bool leads = reference_m_.z < nav.p_world_m.z - 0.05;  // never far below the vehicle
  reference_mps_.z = (centred || committed_now) && !leads ? -sink : 0;
  reference_m_.z += reference_mps_.z * dt_s;
  fly_reference();
  setpoint_.v_world_mps.z = (centred || committed_now) ? -sink : 0;
  if (touched(nav, dt_s)) enter(MissionPhase::touchdown, now);
}

void MissionPlan::run_abort(msg::Time now, const msg::NavState& nav, double dt_s) {
  setpoint_.armed = 1;
  setpoint_.mode = msg::FlightMode::velocity;
  const double slow_below_m = params.slow_below_m + (nav.ground_seen ? 0 : params.slow_unseen_m);
  setpoint_.v_world_mps = {0, 0, nav.height_m > slow_below_m ? -params.sink_fast_mps : -params.sink_slow_mps};
  blind_s_ = nav.height_valid ? 0 : blind_s_ + dt_s;
  if (in_phase_s(now) > params.abort_limit_s || blind_s_ > params.blind_s || (nav.height_valid && touched(nav, dt_s)))
    enter(MissionPhase::done, now);
}

void MissionPlan::lose_pad(msg::Time now) {
  if (++lost_ > params.retries) return enter(MissionPhase::abort, now);
  if (state_.phase != MissionPhase::search) search_centre_m_ = target_m_;
  target_m_ = {search_centre_m_.x, search_centre_m_.y,
               target_m_.z > params.search_height_m ? target_m_.z : params.search_height_m};
  search_leg_ = 0;
  fly_reference();
  enter(MissionPhase::search, now);
}

void MissionPlan::slew(double dt_s) {
  const math::Vec3 away = target_m_ - reference_m_;
  const double far = horizontal(away), step = params.accel_mps2 * dt_s;
  math::Vec3 wish{};
  if (far > 1e-9) {
    const double speed = approach_speed(far, params.speed_mps, params.accel_mps2);
    wish = {away.x / far * speed, away.y / far * speed, 0};
  }
  const double rise = approach_speed(math::fabs(away.z), params.climb_mps, params.accel_mps2);
  wish.z = away.z > 0 ? rise : -rise;
  const math::Vec3 change = limit_horizontal(wish - reference_mps_, step);
  reference_mps_ += math::Vec3{change.x, change.y, clamp(change.z, -step, step)};
  const math::Vec3 moved = reference_mps_ * dt_s;
  const math::Vec3 after = target_m_ - (reference_m_ + moved);
  reference_m_ += moved;
  if (horizontal(after) < 0.01 && horizontal(reference_mps_) < 0.15) {  // arrived: no creeping around the point
    reference_m_.x = target_m_.x;
    reference_m_.y = target_m_.y;
    reference_mps_.x = reference_mps_.y = 0;
  }
  if (math::fabs(after.z) < 0.01 && math::fabs(reference_mps_.z) < 0.15) {
    reference_m_.z = target_m_.z;
    reference_mps_.z = 0;
  }
}

void MissionPlan::fly_reference() {
  setpoint_.armed = 1;
  setpoint_.mode = msg::FlightMode::position;
  setpoint_.p_world_m = reference_m_.to<msg::Vec3>();
  setpoint_.v_world_mps = reference_mps_.to<msg::Vec3>();
}

}  // namespace sinew::control
