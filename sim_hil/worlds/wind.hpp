#pragma once
#include <optional>

#include "math/random.hpp"
#include "msg/geometry.hpp"

namespace sinew::plant {

struct WindOptions {
  double gust_mps = 0;                 // steady part and gusts together are never faster than this, or than steady_mps
  std::optional<double> steady_mps{};  // none: by the seed, up to half of gust_mps
  std::optional<double> toward_rad{};  // where the steady part blows to, counter-clockwise from x; none: by the seed
};

/// Moving air: a steady part in some direction and gusts (first-order filtered noise with the length and time scales of
/// a draughty hall).
class Wind {
 public:
  Wind(const WindOptions& options, std::uint64_t seed);
  /// Advances by one plant step; returns the velocity of the air in the world frame.
  const msg::Vec3& step(double dt_s);
  const msg::Vec3& velocity_mps() const { return velocity_; }

 private:
  double gusts_, limit_;
  math::Random noise_;
  msg::Vec3 mean_, gust_, velocity_;
  std::uint32_t phase_ = 0;
};

}  // namespace sinew::plant
