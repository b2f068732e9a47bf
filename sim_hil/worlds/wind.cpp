#include "sim_hil/worlds/wind.hpp"

#include <algorithm>
#include <cmath>

#include "math/elementary.hpp"

namespace sinew::plant {
namespace {
// Correlation time of the gusts: eddies of some 1.5 m carried at some 1.5 m/s.
constexpr double kCorrelationS = 1.0;
constexpr double kMeanShare = 0.5, kGustShare = 0.25;  // of the limit: largest mean, sigma of the gusts
constexpr double kVerticalShare = 0.4;                 // floor and ceiling hold vertical gusts down
constexpr std::uint32_t kNoiseEvery = 8;               // plant steps per draw: 500 Hz is far above the gusts
}  // namespace

Wind::Wind(const WindOptions& options, std::uint64_t seed)
    : gusts_(options.gust_mps),
      limit_(std::max(options.gust_mps, options.steady_mps.value_or(0))),
      noise_(seed, 0x77696e64) {
  // A direction without sin and cos: a uniform point in the disc, by rejection.
  double x = 0, y = 0;
  do {
    x = noise_.uniform(-1, 1);
    y = noise_.uniform(-1, 1);
  } while (x * x + y * y > 1.0);
  mean_ = {x * kMeanShare * gusts_, y * kMeanShare * gusts_, 0};
  if (options.steady_mps || options.toward_rad) {
    const double drawn = std::sqrt(x * x + y * y);
    const double speed = options.steady_mps.value_or(drawn * kMeanShare * gusts_);
    if (options.toward_rad) {
      const auto toward = math::sincos(*options.toward_rad);
      mean_ = {speed * toward.cos, speed * toward.sin, 0};
    } else {
      mean_ = drawn > 0 ? msg::Vec3{speed * x / drawn, speed * y / drawn, 0} : msg::Vec3{speed, 0, 0};
    }
  }
  velocity_ = mean_;
}

const msg::Vec3& Wind::step(double dt_s) {
  if (limit_ <= 0 || phase_++ % kNoiseEvery != 0) return velocity_;
  const double keep = 1.0 - kNoiseEvery * dt_s / kCorrelationS;
  const double kick = kGustShare * gusts_ * std::sqrt(1.0 - keep * keep);
  gust_.x = keep * gust_.x + kick * noise_.normal();
  gust_.y = keep * gust_.y + kick * noise_.normal();
  gust_.z = keep * gust_.z + kVerticalShare * kick * noise_.normal();
  velocity_ = {mean_.x + gust_.x, mean_.y + gust_.y, mean_.z + gust_.z};
  const double speed = std::sqrt(velocity_.x * velocity_.x + velocity_.y * velocity_.y + velocity_.z * velocity_.z);
  if (speed > limit_) {
    const double s = limit_ / speed;
    velocity_ = {velocity_.x * s, velocity_.y * s, velocity_.z * s};
  }
  return velocity_;
}

}  // namespace sinew::plant
