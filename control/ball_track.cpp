#include "control/ball_track.hpp"

#include "math/elementary.hpp"

namespace sinew::control {
namespace {

constexpr double kFirstSpeed_radps = 1.0;  // 1 sigma, for a ball that is seen for the first time
// After a longer time unseen, the change of place says little about the speed, and a wrong sighting would say much.
constexpr double kAnew_s = 0.09;
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

bool BallTrack::add(msg::Time stamp, const math::Vec3& d, double doubt_rad) {
  const double noise = math::hypot(params.noise_rad, doubt_rad);
  const double azimuth = math::atan2(d.y, d.x), elevation = math::atan2(d.z, math::hypot(d.x, d.y));
  if (!exists_) {
    begin(stamp, azimuth, elevation, noise);
    return true;
  }
  const double dt = msg::seconds(stamp - stamp_);
  if (dt <= 0) return false;
  if (dt > kAnew_s) {
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

BallTrack::Aim BallTrack::at(msg::Time t) const {
  const double dt = msg::seconds(t - stamp_), later = dt - kMoment_s;
  double ahead = dt, keeps = 1;  // seconds at the last speed; the share of it that is left
  if (later > 0 && params.settle_s > 0) {
    keeps = math::exp(-later / params.settle_s);
    ahead = kMoment_s + params.settle_s * (1 - keeps);
    if (dt > kPass_s) ahead *= kRest + (1 - kRest) * math::exp((kPass_s - dt) / kBack_s);
  }
  return {math::wrap_pi(azimuth_.x + azimuth_.v * ahead), elevation_.x + elevation_.v * ahead, azimuth_.v * keeps,
          elevation_.v * keeps};
}

}  // namespace sinew::control
