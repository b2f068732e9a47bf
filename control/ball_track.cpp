#include "control/ball_track.hpp"

#include <algorithm>

#include "math/elementary.hpp"

namespace sinew::control {
namespace {

using math::Vec3;

constexpr double kFirstSpeed_radps = 1.0;  // 1 sigma, for a ball that is seen for the first time
// A ball that does not come out on the far side in this time has stopped or turned behind the thing that hides it: the
// prediction goes back towards the place where the ball was lost, but for a share of the way.
constexpr double kPass_s = 0.6, kBack_s = 0.4, kRest = 0.3;
constexpr double kMoment_s = 0.15;  // for so long a prediction is as good as the last speed

}  // namespace

void BallTrack::Axis::begin(double at, double noise) {
  *this = {at, 0, noise * noise, 0, kFirstSpeed_radps * kFirstSpeed_radps};
}

void BallTrack::Axis::predict(double dt, double accel) {
  const double q = accel * accel, dt2 = dt * dt;
  x += v * dt;
  xx += 2 * xv * dt + vv * dt2 + 0.25 * q * dt2 * dt2;
  xv += vv * dt + 0.5 * q * dt2 * dt;
  vv += q * dt2;
}

double BallTrack::Axis::normalised(double innovation, double noise) const {
  return innovation * innovation / (xx + noise * noise);
}

void BallTrack::Axis::update(double innovation, double noise) {
  const double s = xx + noise * noise, kx = xx / s, kv = xv / s;
  x += kx * innovation;
  v += kv * innovation;
  vv -= kv * xv;
  xv -= kx * xv;
  xx -= kx * xx;
}

void BallTrack::reset() {
  const BallTrackParams keep = params;
  *this = {};
  params = keep;
}

void BallTrack::begin(msg::Time stamp, double azimuth, double elevation, double noise_rad) {
  azimuth_.begin(azimuth, noise_rad);
  elevation_.begin(elevation, noise_rad);
  stamp_ = stamp;
  refused_ = 0;
  innovation_rad_ = 0;
  exists_ = 1;
  ++used_;
}

/// The same filter on the direction itself, whose three parts have one covariance.
bool BallTrack::add_direction(msg::Time stamp, const Vec3& d, double noise) {
  const double dt = msg::seconds(stamp - stamp_);
  Axis all = azimuth_;
  all.predict(dt, params.accel_radps2);
  const Vec3 predicted = math::normalized(direction_ + dt * rate_), off = d - predicted;
  if (all.normalised(math::norm(off), noise) > params.gate) {
    if (++refused_ < params.refuse) return false;
    begin_direction(stamp, d, {}, noise);
    return true;
  }
  const double s = all.xx + noise * noise;
  direction_ = math::normalized(predicted + (all.xx / s) * off);
  rate_ += (all.xv / s) * off;
  rate_ -= dot(rate_, direction_) * direction_;
  all.update(0, noise);
  azimuth_ = all;
  stamp_ = stamp;
  refused_ = 0;
  innovation_rad_ = math::norm(off);
  ++used_;
  return true;
}

void BallTrack::begin_direction(msg::Time stamp, const Vec3& d, const Vec3& rate, double noise) {
  begin(stamp, 0, 0, noise);
  direction_ = d;
  rate_ = rate - dot(rate, d) * d;
}

BallTrack::Aim BallTrack::aim_of(const Vec3& d, const Vec3& rate) {
  constexpr double kLeast = 1e-6;  // straight below every azimuth is right
  const double flat2 = std::max(d.x * d.x + d.y * d.y, kLeast), flat = math::sqrt(flat2);
  return {math::atan2(d.y, d.x), math::atan2(d.z, math::hypot(d.x, d.y)), (d.x * rate.y - d.y * rate.x) / flat2,
          rate.z / flat};
}

bool BallTrack::add(msg::Time stamp, const math::Vec3& d, double doubt_rad) {
  const double noise = math::hypot(params.noise_rad, doubt_rad);
  const double azimuth = math::atan2(d.y, d.x), elevation = math::atan2(d.z, math::hypot(d.x, d.y));
  if (!exists_) {
    begin_direction(stamp, d, {}, noise);
    azimuth_.x = azimuth, elevation_.x = elevation;
    return true;
  }
  const double dt = msg::seconds(stamp - stamp_);
  if (dt <= 0) return false;
  if (params.below != 0) {
    if (dt <= params.anew_s) return add_direction(stamp, d, noise);
    const double keeps = kept(dt);
    begin_direction(stamp, d, keeps * rate_, noise);
    return true;
  }
  if (dt > params.anew_s) {
    const Aim a = at(stamp);
    begin(stamp, azimuth, elevation, noise);
    azimuth_.v = a.azimuth_radps, elevation_.v = a.elevation_radps;
    return true;
  }
  Axis az = azimuth_, el = elevation_;
  az.predict(dt, params.accel_radps2);
  el.predict(dt, params.accel_radps2);
  const double off_az = math::wrap_pi(azimuth - az.x), off_el = elevation - el.x;
  const bool fits = az.normalised(off_az, noise) + el.normalised(off_el, noise) <= params.gate;
  if (!fits && ++refused_ < params.refuse) return false;
  if (!fits) {
    begin(stamp, azimuth, elevation, noise);
    return true;
  }
  az.update(off_az, noise);
  el.update(off_el, noise);
  az.x = math::wrap_pi(az.x);
  azimuth_ = az, elevation_ = el;
  stamp_ = stamp;
  refused_ = 0;
  innovation_rad_ = math::hypot(off_az, off_el);
  ++used_;
  return true;
}

/// The share of its speed that an unseen ball has left.
double BallTrack::kept(double unseen_s) const {
  const double later = unseen_s - kMoment_s;
  return later > 0 && params.settle_s > 0 ? math::exp(-later / params.settle_s) : 1;
}

BallTrack::Aim BallTrack::at(msg::Time t) const {
  const double dt = msg::seconds(t - stamp_), later = dt - kMoment_s;
  const double keeps = kept(dt);
  double ahead = dt;  // seconds at the last speed
  if (later > 0 && params.settle_s > 0) {
    ahead = kMoment_s + params.settle_s * (1 - keeps);
    if (dt > kPass_s) ahead *= kRest + (1 - kRest) * math::exp((kPass_s - dt) / kBack_s);
  }
  if (params.below != 0) return aim_of(math::normalized(direction_ + ahead * rate_), keeps * rate_);
  return {math::wrap_pi(azimuth_.x + azimuth_.v * ahead), elevation_.x + elevation_.v * ahead, azimuth_.v * keeps,
          elevation_.v * keeps};
}

}  // namespace sinew::control
