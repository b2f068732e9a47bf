#include "control/heading_bank.hpp"

#include "control/inertial_filter.hpp"
#include "control/limits.hpp"

namespace sinew::control {
namespace {

constexpr msg::Duration kSpacing{5'000'000};
constexpr double kLongest_s = 2;       // between two velocities: start anew
constexpr double kLeastWeight = 1e-3;  // so that a filter that was wrong for a while can come back

}  // namespace

void HeadingBank::add_imu(msg::Time stamp, const math::Vec3& gyro_radps, const math::Vec3& accel_mps2, double dt_s) {
  if (levelled_ == 0) {
    if (!(math::norm(accel_mps2) > 0.5 * kGravity)) return;
    q_level_base_ = math::Quat::between(accel_mps2, {0, 0, 1});
    levelled_ = 1;
  }
  const math::Vec3 up = q_level_base_.conjugate().rotate({0, 0, 1});
  const double length = math::norm(accel_mps2);
  const double trust = length > 0 ? 1 - math::fabs(length - kGravity) / (0.3 * kGravity) : 0;
  math::Vec3 rate = gyro_radps;
  if (trust > 0) rate += cross(accel_mps2 / length, up) * (params.tilt_gain * trust);
  const math::Quat half = q_level_base_ * math::Quat::exp(rate * (0.5 * dt_s));
  const math::Vec3 f = half.rotate(accel_mps2);
  dv_mps_ += math::Vec3{f.x, f.y, 0} * dt_s;
  q_level_base_ = (q_level_base_ * math::Quat::exp(rate * dt_s)).normalized();

  if (count_ && stamp - sums_[(first_ + count_ - 1) % kSums].stamp < kSpacing) return;
  sums_[(first_ + count_) % kSums] = {stamp, dv_mps_};
  if (count_ < kSums)
    ++count_;
  else
    first_ = (first_ + 1) % kSums;
}

std::optional<math::Vec3> HeadingBank::sum_at(msg::Time t) const {
  if (!count_ || t < sums_[first_ % kSums].stamp) return std::nullopt;
  for (std::uint32_t i = count_; i-- > 0;) {
    const Sum& a = sums_[(first_ + i) % kSums];
    if (a.stamp > t) continue;
    if (i + 1 == count_) return dv_mps_;
    const Sum& b = sums_[(first_ + i + 1) % kSums];
    const double s = static_cast<double>((t - a.stamp).count()) / static_cast<double>((b.stamp - a.stamp).count());
    return a.dv_mps + (b.dv_mps - a.dv_mps) * s;
  }
  return std::nullopt;
}

void HeadingBank::start(double east_mps, double north_mps, double sigma_mps) {
  for (std::size_t i = 0; i < kFilters; ++i) {
    Filter& f = filters_[i];
    f = {east_mps, north_mps, 2 * math::kPi * static_cast<double>(i) / kFilters - math::kPi, 1.0 / kFilters, {}};
    f.p(0, 0) = f.p(1, 1) = square(sigma_mps);
    f.p(2, 2) = square(math::kPi / kFilters);
  }
  running_ = 1;
}

void HeadingBank::add_velocity(msg::Time stamp, double east_mps, double north_mps, double sigma_mps) {
  const std::optional<math::Vec3> dv = sum_at(stamp);
  if (!dv || !(sigma_mps > 0) || !(math::fabs(east_mps) < 1e3) || !(math::fabs(north_mps) < 1e3)) return;
  const double dt_s = msg::seconds(stamp - before_);
  if (running_ != 0 && dt_s <= 0) return;
  const math::Vec3 d = *dv - dv_before_mps_;
  dv_before_mps_ = *dv;
  before_ = stamp;
  if (running_ == 0 || dt_s > kLongest_s) return start(east_mps, north_mps, sigma_mps);

  double total = 0;
  for (Filter& f : filters_) {
    const math::SinCos a = math::sincos(f.angle_rad);
    const double de = a.cos * d.x - a.sin * d.y, dn = a.sin * d.x + a.cos * d.y;
    f.east_mps += de;
    f.north_mps += dn;
    const math::Mat3 transition{1, 0, -dn, 0, 1, de, 0, 0, 1};
    f.p = transition * f.p * transition.transpose();
    f.p(0, 0) += square(params.accel_noise) * dt_s;
    f.p(1, 1) += square(params.accel_noise) * dt_s;
    f.p(2, 2) += square(params.angle_walk) * dt_s;

    const double r = square(sigma_mps), re = east_mps - f.east_mps, rn = north_mps - f.north_mps;
    const double see = f.p(0, 0) + r, sen = f.p(0, 1), snn = f.p(1, 1) + r, det = see * snn - sen * sen;
    double distance = (snn * re * re - 2 * sen * re * rn + see * rn * rn) / det;
    if (distance > 25) distance = 25;  // one wild velocity does not decide for ever
    f.weight *= math::exp(-0.5 * distance) / math::sqrt(det);
    math::Mat<3, 2> gain;
    for (int i = 0; i < 3; ++i) {
      gain(i, 0) = (f.p(i, 0) * snn - f.p(i, 1) * sen) / det;
      gain(i, 1) = (f.p(i, 1) * see - f.p(i, 0) * sen) / det;
    }
    const math::Mat<2, 3> top{f.p(0, 0), f.p(0, 1), f.p(0, 2), f.p(1, 0), f.p(1, 1), f.p(1, 2)};
    f.p = (f.p - gain * top).symmetric();
    f.east_mps += gain(0, 0) * re + gain(0, 1) * rn;
    f.north_mps += gain(1, 0) * re + gain(1, 1) * rn;
    f.angle_rad = math::wrap_pi(f.angle_rad + gain(2, 0) * re + gain(2, 1) * rn);
    total += f.weight;
  }
  if (!(total > 0)) return start(east_mps, north_mps, sigma_mps);
  double floored = 0;
  for (Filter& f : filters_) {
    f.weight /= total;
    if (f.weight < kLeastWeight) f.weight = kLeastWeight;
    floored += f.weight;
  }
  for (Filter& f : filters_) f.weight /= floored;
}

math::Vec3 HeadingBank::mean_direction() const {
  math::Vec3 sum;
  for (const Filter& f : filters_) {
    const math::SinCos a = math::sincos(f.angle_rad);
    sum += math::Vec3{a.cos, a.sin, 0} * f.weight;
  }
  return sum;
}

double HeadingBank::heading_rad() const {
  const math::Vec3 mean = mean_direction();
  return math::wrap_pi(q_level_base_.yaw() + math::atan2(mean.y, mean.x));
}

double HeadingBank::std_rad() const {
  constexpr double kNothingKnown = 1.8137993642342178;  // pi / sqrt(3)
  if (running_ == 0) return kNothingKnown;
  const math::Vec3 mean = mean_direction();
  const double centre = math::atan2(mean.y, mean.x);
  double variance = 0;
  for (const Filter& f : filters_) variance += f.weight * (f.p(2, 2) + square(math::wrap_pi(f.angle_rad - centre)));
  const double sigma = math::sqrt(variance);
  return sigma < kNothingKnown ? sigma : kNothingKnown;
}

}  // namespace sinew::control
