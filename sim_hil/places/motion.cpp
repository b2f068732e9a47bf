#include "sim_hil/places/motion.hpp"

#include <algorithm>

#include "sim_hil/worlds/world.hpp"

namespace sinew::plant {

using math::Quat;
using math::Vec3;
using math::YawPitchRoll;

namespace {

constexpr double kLeanLag_s = 0.08, kFeelLag_s = 0.01;
constexpr double kSteepest = 0.7;   // z of a normal: flatter ground bears a vehicle, steeper does not
constexpr double kSinks_mps = 1.0;  // with an empty battery
constexpr double kLiftOff_mps = 0.02;
constexpr double kFeet_m = 0.002;  // nearer to the ground it stands
constexpr double kLook_m = 0.30;   // so far over its wheels, ground is looked for
constexpr double kDrop_m = 3.0;    // ground that is further below is none

Vec3 turned(const Vec3& v, double yaw_rad) {
  const math::SinCos a = math::sincos(yaw_rad);
  return {v.x * a.cos - v.y * a.sin, v.x * a.sin + v.y * a.cos, v.z};
}

/// `v` no longer than `most`.
Vec3 limited(const Vec3& v, double most) {
  const double n = math::norm(v);
  return n > most ? (most / n) * v : v;
}

double toward(double from, double to, double share) { return from + std::min(share, 1.0) * (to - from); }

/// Pushes the hull's ball out of whatever it is in, and takes the velocity into it away.
void keep_out(BodyState& body, const VehicleKind& kind, const Surroundings& around) {
  const Vec3 up{0, 0, kind.hull_up_m};
  around.near(body.p_world_m + up, kind.hull_radius_m, [&](const Solid& s) {
    const Clearance c = clearance(s, body.p_world_m + up);
    const double depth = kind.hull_radius_m - c.distance_m;
    if (c.out.z > kSteepest && depth > -kFeet_m) body.stands = true;
    if (depth <= 0) return;
    body.p_world_m += depth * c.out;
    const double into = dot(body.v_world_mps, c.out);
    if (into < 0) body.v_world_mps -= into * c.out;
    if (c.out.z <= kSteepest) body.touches = true;
  });
}

}  // namespace

Vec3 BodyState::gyro_radps() const {
  const math::SinCos f = math::sincos(angles_rad.roll), p = math::sincos(angles_rad.pitch);
  const YawPitchRoll& d = rates_radps;
  return {d.roll - d.yaw * p.sin, d.pitch * f.cos + d.yaw * f.sin * p.cos, d.yaw * f.cos * p.cos - d.pitch * f.sin};
}

// ---- rotors

/// It leans into its acceleration, and against the drag.
void RotorMotion::lean(BodyState& body, const Vec3& accel_heading, const Vec3& wind_mps, double dt_s) {
  const Vec3 v = turned(body.v_world_mps - wind_mps, -body.angles_rad.yaw);
  const double pitch = math::atan2(accel_heading.x + kind_->drag_per_s * v.x, kGravity);
  const double roll = -math::atan2(accel_heading.y + kind_->drag_per_s * v.y, kGravity);
  const double share = dt_s / kLeanLag_s;
  const auto lean_to = [&](double& angle, double& rate, double wanted) {
    const double next = toward(angle, body.stands ? 0 : wanted, share);
    rate = (next - angle) / dt_s;
    angle = next;
  };
  lean_to(body.angles_rad.pitch, body.rates_radps.pitch, pitch);
  lean_to(body.angles_rad.roll, body.rates_radps.roll, roll);
}

void RotorMotion::step(BodyState& body, const RotorCommand& command, bool powered, const Vec3& wind_mps,
                       const Surroundings& around, double dt_s) {
  const VehicleKind& k = *kind_;
  const Vec3 level = limited({command.v_mps.x, command.v_mps.y, 0}, k.speed_mps);
  Vec3 wanted{level.x, level.y, std::clamp(command.v_mps.z, -k.climb_mps, k.climb_mps)};
  double turn = std::clamp(command.turn_radps, -k.turn_radps, k.turn_radps);
  if (!powered) wanted = {0, 0, -kSinks_mps}, turn = 0;
  const bool held = body.stands && wanted.z < kLiftOff_mps;  // on its feet
  if (held) wanted = {}, turn = 0;

  const Vec3 before = body.v_world_mps;
  const Vec3 v_heading = turned(before, -body.angles_rad.yaw);
  const Vec3 accel = limited((1 / k.lag_s) * (wanted - v_heading), k.accel_mps2);
  body.v_world_mps += dt_s * turned(accel, body.angles_rad.yaw);
  if (!held) body.v_world_mps += (dt_s * k.drag_per_s) * wind_mps;
  body.p_world_m += dt_s * body.v_world_mps;
  body.rates_radps.yaw = toward(body.rates_radps.yaw, turn, dt_s / k.lag_s);
  body.angles_rad.yaw = math::wrap_pi(body.angles_rad.yaw + dt_s * body.rates_radps.yaw);
  const bool stood = body.stands;
  body.stands = body.touches = false;
  keep_out(body, k, around);
  if (held && stood) body.stands = true, body.v_world_mps = {};
  lean(body, accel, wind_mps, dt_s);
  const double share = dt_s / kFeelLag_s;
  body.accel_world_mps2 += std::min(share, 1.0) * ((1 / dt_s) * (body.v_world_mps - before) - body.accel_world_mps2);
}

// ---- wheels

double WheelMotion::Feet::highest() const { return std::max({front_left, front_right, rear_left, rear_right}); }

WheelMotion::Feet WheelMotion::feet(const Vec3& p, double yaw, const Surroundings& around) const {
  const double x = kind_->wheelbase_m / 2, y = kind_->track_m / 2;
  const auto height = [&](double forward, double left) {
    Vec3 from = p + turned({forward, left, 0}, yaw);
    from.z += kLook_m;
    const auto ground = around.beam(from, {0, 0, -1}, kLook_m + kDrop_m);
    return from.z - (ground ? ground->range_m : kLook_m + kDrop_m);
  };
  return {height(x, y), height(x, -y), height(-x, y), height(-x, -y)};
}

bool WheelMotion::fits(const Vec3& p, const Feet& f, bool forward, const Surroundings& around) const {
  if (f.highest() > p.z - kind_->rest_m + kind_->step_m) return false;
  const double up = (f.front_left + f.front_right - f.rear_left - f.rear_right) / 2, rise = forward ? up : -up;
  const math::SinCos steepest = math::sincos(kind_->slope_rad);
  const bool edge = rise <= kind_->step_m;  // one pair of wheels on a step
  if (!edge && rise * steepest.cos > kind_->wheelbase_m * steepest.sin) return false;
  bool clear = true;
  const Vec3 hull = p + Vec3{0, 0, kind_->hull_up_m};
  around.near(hull, kind_->hull_radius_m, [&](const Solid& s) {
    const Clearance c = clearance(s, hull);
    if (c.distance_m < kind_->hull_radius_m && c.out.z < kSteepest) clear = false;
  });
  return clear;
}

void WheelMotion::step(BodyState& body, double left, double right, const Surroundings& around, double dt_s) {
  const VehicleKind& k = *kind_;
  const double share = dt_s / k.wheel_lag_s;
  left_radps_ = toward(left_radps_, std::clamp(left, -k.wheel_radps, k.wheel_radps), share);
  right_radps_ = toward(right_radps_, std::clamp(right, -k.wheel_radps, k.wheel_radps), share);
  left_rad_ += dt_s * left_radps_, right_rad_ += dt_s * right_radps_;

  roll(body,
       {k.wheel_radius_m * (left_radps_ + right_radps_) / 2, 0,
        k.wheel_radius_m * (right_radps_ - left_radps_) / k.track_m},
       around, dt_s);
}

void WheelMotion::step(BodyState& body, const SteerCommand& command, const Surroundings& around, double dt_s) {
  const VehicleKind& k = *kind_;
  spin_radps_ =
      toward(spin_radps_, std::clamp(command.spin_radps, -k.wheel_radps, k.wheel_radps), dt_s / k.wheel_lag_s);
  const auto steer = [&](double& angle, double wanted, double most) {
    const double turn = std::clamp(wanted, -most, most) - angle, step = k.steer_radps * dt_s;
    angle += std::clamp(turn, -step, step);
  };
  steer(front_rad_, command.front_rad, k.front_steer_rad);
  steer(rear_rad_, command.rear_rad, k.rear_steer_rad);
  // Base is in the middle between the axles: what moves an axle sideways is its forward motion times the tangent of its
  // wheels' angle.
  const math::SinCos front = math::sincos(front_rad_), rear = math::sincos(rear_rad_);
  const double front_slope = front.sin / front.cos, rear_slope = rear.sin / rear.cos;
  Rolling r;
  r.along_mps = k.wheel_radius_m * spin_radps_;
  r.side_mps = r.along_mps * (front_slope + rear_slope) / 2;
  r.turn_radps = r.along_mps * (front_slope - rear_slope) / k.wheelbase_m;
  const double outer = r.turn_radps * k.track_m / 2 / k.wheel_radius_m;
  left_radps_ = spin_radps_ - outer, right_radps_ = spin_radps_ + outer;
  left_rad_ += dt_s * left_radps_, right_rad_ += dt_s * right_radps_;
  roll(body, r, around, dt_s);
}

void WheelMotion::roll(BodyState& body, const Rolling& rolling, const Surroundings& around, double dt_s) {
  const VehicleKind& k = *kind_;
  const double along = rolling.along_mps, turn = rolling.turn_radps;
  const Vec3 before = body.v_world_mps;
  const math::SinCos slope = math::sincos(body.angles_rad.pitch);
  const double yaw = math::wrap_pi(body.angles_rad.yaw + dt_s * turn);
  Vec3 next = body.p_world_m + dt_s * turned({along * slope.cos, rolling.side_mps, 0}, body.angles_rad.yaw);
  Feet ground = feet(next, yaw, around);
  body.touches = !fits(next, ground, along >= 0, around);
  // What was put into something may roll out of it.
  const auto caught = [&] {
    return !fits(body.p_world_m, feet(body.p_world_m, body.angles_rad.yaw, around), along >= 0, around);
  };
  const bool rolls = body.stands && (!body.touches || caught());
  body.rates_radps.yaw = rolls ? turn : 0;
  if (rolls)
    body.angles_rad.yaw = yaw;
  else
    next = body.p_world_m, ground = feet(next, body.angles_rad.yaw, around);

  // It stands on its wheels, or falls until it does.
  const double rest_z = ground.mean() + k.rest_m;
  fall_mps_ = body.stands ? 0 : fall_mps_ + dt_s * kGravity;
  const double fallen_z = body.p_world_m.z - dt_s * fall_mps_;
  constexpr double kFollows_mps = 2;  // springs of tyres: edges are climbed in a moment, not at once
  const double drop = body.p_world_m.z - rest_z;
  if (drop <= 0)
    next.z = std::min(rest_z, body.p_world_m.z + dt_s * kFollows_mps), body.stands = true;
  else if (body.stands && drop <= k.step_m)
    next.z = std::max(rest_z, body.p_world_m.z - dt_s * kFollows_mps);
  else
    next.z = std::max(rest_z, fallen_z), body.stands = fallen_z <= rest_z;
  body.v_world_mps = (1 / dt_s) * (next - body.p_world_m);
  body.p_world_m = next;

  const double pitch =
      math::atan2((ground.rear_left + ground.rear_right - ground.front_left - ground.front_right) / 2, k.wheelbase_m);
  const double roll =
      math::atan2((ground.front_left + ground.rear_left - ground.front_right - ground.rear_right) / 2, k.track_m);
  const auto lean_to = [&](double& angle, double& rate, double wanted) {
    const double to = body.stands ? toward(angle, wanted, dt_s / kLeanLag_s) : angle;
    rate = (to - angle) / dt_s;
    angle = to;
  };
  lean_to(body.angles_rad.pitch, body.rates_radps.pitch, std::clamp(pitch, -k.slope_rad, k.slope_rad));
  lean_to(body.angles_rad.roll, body.rates_radps.roll, std::clamp(roll, -k.slope_rad, k.slope_rad));
  body.accel_world_mps2 +=
      std::min(dt_s / kFeelLag_s, 1.0) * ((1 / dt_s) * (body.v_world_mps - before) - body.accel_world_mps2);
}

}  // namespace sinew::plant
