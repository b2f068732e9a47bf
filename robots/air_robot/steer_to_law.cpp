#include "robots/air_robot/steer_to_law.hpp"

#include <algorithm>

#include "control/limits.hpp"

namespace sinew::air_robot {

using control::clamp;
using math::Vec3;
using msg::HeadMode;
using msg::MissionPhase;

namespace {

Vec3 turned_by(const Vec3& v, double yaw_rad) {
  const math::SinCos a = math::sincos(yaw_rad);
  return {v.x * a.cos - v.y * a.sin, v.x * a.sin + v.y * a.cos, v.z};
}

}  // namespace

void SteerToLaw::reset() {
  const SteerToParams keep = params;
  *this = {};
  params = keep;
}

void SteerToLaw::set_safety(const msg::SafetyState& safety) {
  permitted_ = safety.permitted;
  action_ = safety.action;
}

void SteerToLaw::enter(MissionPhase phase, msg::Time now) {
  if (mission_.phase == phase) return;
  mission_.phase = phase;
  mission_.phase_since = now;
}

bool SteerToLaw::flies() const {
  const MissionPhase phase = mission_.phase;
  return phase == MissionPhase::climb || phase == MissionPhase::search || steers();
}

/// Over the target at its end it stays there.
bool SteerToLaw::steers() const {
  const MissionPhase phase = mission_.phase;
  return phase == MissionPhase::approach || phase == MissionPhase::hold ||
         (phase == MissionPhase::done && landed_ == 0);
}

void SteerToLaw::choose_phase(msg::Time now, const msg::NavState& nav, bool seen) {
  constexpr double kLeave = 2;     // of arrived_m: over the target until it is so far
  constexpr double kDown_s = 0.5;  // so long below landed_m it is on the ground
  const double far_m = math::hypot(target_.x, target_.y);
  const MissionPhase phase = mission_.phase;
  if (flies() && action_ != msg::FailsafeAction::none) return enter(MissionPhase::descend, now);
  if (phase == MissionPhase::wait && permitted_ != 0 && action_ == msg::FailsafeAction::none)
    enter(MissionPhase::climb, now);
  else if (phase == MissionPhase::climb && nav.p_world_m.z > 0.8 * params.height_m)
    enter(MissionPhase::search, now);
  else if (phase == MissionPhase::search && seen)
    enter(MissionPhase::approach, now);
  else if ((phase == MissionPhase::approach || phase == MissionPhase::hold) && !seen)
    enter(MissionPhase::search, now);
  else if (phase == MissionPhase::approach && far_m < params.arrived_m)
    enter(MissionPhase::hold, now);
  else if (phase == MissionPhase::hold && far_m > kLeave * params.arrived_m)
    enter(MissionPhase::approach, now);
  else if (phase == MissionPhase::hold && msg::seconds(now - mission_.phase_since) > params.stay_s)
    enter(MissionPhase::done, now);
  else if (phase == MissionPhase::descend && low_s_ > kDown_s)
    landed_ = 1, enter(MissionPhase::done, now);
}

/// The point of the head's ray at the target's height.
void SteerToLaw::place_target(const msg::NavState& nav, const msg::HeadState& head) {
  const double yaw = math::Quat(nav.q_world_base).yaw();
  const double below_rad = clamp(-head.elevation_rad, params.level_rad, math::kPi - params.level_rad);
  const math::SinCos down = math::sincos(below_rad);
  const Vec3 eye = math::Quat(nav.q_world_base).rotate({params.camera_x_m, 0, params.camera_z_m});
  const double over_m = std::max(nav.p_world_m.z + eye.z - params.target_height_m, 0.0);
  const double far_m = clamp(over_m * down.cos / down.sin, -params.farthest_m, params.farthest_m);
  const math::SinCos to = math::sincos(head.azimuth_rad);
  target_ = turned_by({eye.x + far_m * to.cos, eye.y + far_m * to.sin, 0}, -yaw);
  target_.z = params.target_height_m - nav.p_world_m.z;
  mission_.target_world_m = turned_by(target_, yaw).to<msg::Vec3>();
}

void SteerToLaw::fly(const msg::NavState& nav, double dt_s) {
  const double yaw = math::Quat(nav.q_world_base).yaw();
  const double far_m = math::hypot(target_.x, target_.y);
  const Vec3 before{velocity_.x, velocity_.y, 0};
  velocity_ = {};
  turn_ = 0;
  if (flies())
    velocity_.z = clamp(params.height_per_s * (params.height_m - nav.p_world_m.z), -params.climb_mps, params.climb_mps);
  if (mission_.phase == MissionPhase::descend) velocity_.z = -params.climb_mps;
  Vec3 wanted = flies() ? turned_by(learned_world_mps_, -yaw) : Vec3{};
  const Vec3 to{target_.x, target_.y, 0};
  constexpr double kForget_s = 1.5;
  if (mission_.phase == MissionPhase::search) learned_world_mps_ -= (dt_s / kForget_s) * learned_world_mps_;
  if (steers()) wanted += control::limit_horizontal(params.gain_per_s * to, params.speed_mps);
  const Vec3 change = control::limit_horizontal(wanted - before, params.accel_mps2 * dt_s);
  velocity_.x = before.x + change.x;
  velocity_.y = before.y + change.y;
  if (!steers()) return;
  if (far_m < params.learn_within_m) {
    learned_world_mps_ += (params.learn_per_s2 * dt_s) * turned_by(to, yaw);
    learned_world_mps_ = control::limit_horizontal(learned_world_mps_, params.learn_most_mps);
  }
  if (far_m > params.turn_from_m)
    turn_ = clamp(params.turn_per_s * math::atan2(target_.y, target_.x), -params.turn_radps, params.turn_radps);
}

void SteerToLaw::step(msg::Time now, const msg::NavState& nav, const msg::HeadState& head, double dt_s) {
  const bool seen = head.mode == HeadMode::follow || head.mode == HeadMode::coast;
  if (seen) place_target(nav, head);
  mission_.stamp = now;
  mission_.pad_known = seen ? 1 : 0;
  low_s_ = mission_.phase == MissionPhase::descend && nav.height_m < params.landed_m ? low_s_ + dt_s : 0;
  choose_phase(now, nav, seen);
  fly(nav, dt_s);
}

}  // namespace sinew::air_robot
