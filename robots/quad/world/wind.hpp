#pragma once
#include "math/random.hpp"
#include "msg/geometry.hpp"

namespace sinew::plant {

/// Moving air: a steady part from a random direction and gusts (first-order filtered noise with the length and time
/// scales of a draughty hall), together never faster than `limit_mps`.
class Wind {
 public:
  Wind(double limit_mps, std::uint64_t seed);
  /// Advances by one plant step; returns the velocity of the air in the world frame.
  const msg::Vec3& step(double dt_s);
  const msg::Vec3& velocity_mps() const { return velocity_; }

 private:
  double limit_;
  math::Random noise_;
  msg::Vec3 mean_, gust_, velocity_;
  std::uint32_t phase_ = 0;
};

}  // namespace sinew::plant
