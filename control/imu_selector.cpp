#include "control/imu_selector.hpp"

namespace sinew::control {
namespace {

constexpr double kLowPass_s = 0.05, kFitTime_s = 2;

double middle(double a, double b, double c) {
  const double low = a < b ? a : b, high = a < b ? b : a;
  return c < low ? low : c > high ? high : c;
}

math::Vec3 middle(const math::Vec3& a, const math::Vec3& b, const math::Vec3& c) {
  return {middle(a.x, b.x, c.x), middle(a.y, b.y, c.y), middle(a.z, b.z, c.z)};
}

}  // namespace

void ImuSelector::add_sample(std::uint32_t i, msg::Time now, const math::Vec3& gyro, const math::Vec3& accel) {
  Lane& lane = lanes_[i];
  const double dt_s = lane.seen != 0 ? msg::seconds(now - lane.last) : kLowPass_s * 1e6;
  const double share = dt_s > 0 ? dt_s / (kLowPass_s + dt_s) : 0;
  lane.gyro += (gyro - lane.gyro) * share;
  lane.accel += (accel - lane.accel) * share;
  lane.last = now;
  lane.seen = 1;
}

void ImuSelector::add_fit(std::uint32_t i, double test_ratio, double dt_s) {
  const double bounded = test_ratio < 10 ? test_ratio : 10;
  lanes_[i].fit += (bounded - lanes_[i].fit) * (dt_s / (kFitTime_s + dt_s));
}

bool ImuSelector::usable(std::uint32_t i, msg::Time now) const {
  const Lane& lane = lanes_[i];
  return lane.seen != 0 && lane.out == 0 && msg::seconds(now - lane.last) < params.silent_s;
}

void ImuSelector::vote(msg::Time now) {
  for (const Lane& lane : lanes_)
    if (lane.seen == 0 || msg::seconds(now - lane.last) >= params.silent_s) return;  // two cannot vote
  const math::Vec3 gyro = middle(lanes_[0].gyro, lanes_[1].gyro, lanes_[2].gyro);
  const math::Vec3 accel = middle(lanes_[0].accel, lanes_[1].accel, lanes_[2].accel);
  for (Lane& lane : lanes_) {
    const bool apart = norm(lane.gyro - gyro) > params.gyro_radps || norm(lane.accel - accel) > params.accel_mps2;
    (apart ? lane.close_since : lane.apart_since) = now;
    if (apart && msg::seconds(now - lane.apart_since) > params.out_after_s) lane.out = 1;
    if (!apart && msg::seconds(now - lane.close_since) > params.back_after_s) lane.out = 0;
  }
}

std::uint32_t ImuSelector::choose(std::uint32_t count, msg::Time now) {
  if (count == kMost) vote(now);
  std::uint32_t best = kMost;
  for (std::uint32_t i = 0; i < count; ++i)
    if (usable(i, now) && (best == kMost || lanes_[i].fit < lanes_[best].fit)) best = i;
  if (best == kMost) return chosen_;  // none is usable: there is nothing better to say
  if (!usable(chosen_, now)) {
    chosen_ = best;
  } else if (best != chosen_ && lanes_[best].fit < params.better_share * lanes_[chosen_].fit) {
    if (rival_ != best) better_since_ = now;
    rival_ = best;
    if (msg::seconds(now - better_since_) > params.better_for_s) chosen_ = best;
    return chosen_;
  }
  rival_ = chosen_;
  return chosen_;
}

}  // namespace sinew::control
