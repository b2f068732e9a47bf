#include "robots/quad/landing_view.hpp"

#include "control/limits.hpp"

namespace sinew::control {
namespace {

constexpr double kSeesAgain = 1.3;  // of blind_below_m: so much higher, pictures are used again
constexpr double kMostGap_s = 0.5;  // between pictures; a longer one is no time step
constexpr double kLeastHeight_m = 0.02, kMostHeight_m = 50;

}  // namespace

void LandingView::reset() {
  offset_m_ = offset_mps_ = {};
  height_m_ = height_mps_ = unseen_s_ = 0;
  stamp_ = {};
  known_ = blind_ = 0;
}

bool LandingView::measure(const msg::PadSighting& s, const msg::NavState& nav, Seen& seen) const {
  if (s.found == 0 || !(s.confidence >= params.min_confidence) || !math::is_finite(s.range_m)) return false;
  // The attitude at the instant of the picture, from the newest one and the rate of turning.
  const double age_s = msg::seconds(nav.stamp - s.stamp);
  if (!(math::fabs(age_s) < kMostGap_s)) return false;
  const math::Quat then = math::Quat(nav.q_world_base) * math::Quat::exp(math::Vec3(nav.gyro_radps) * -age_s);
  const math::Vec3 d = (then * params.q_base_optical).rotate(math::Vec3(s.direction_optical));
  if (!(d.z < -0.2)) return false;  // seen far aside: a circle's size says little there
  const double height_m = s.range_m * -d.z;
  if (!(height_m > kLeastHeight_m && height_m < kMostHeight_m)) return false;
  seen = {{d.x / -d.z * height_m, d.y / -d.z * height_m}, height_m};
  return true;
}

void LandingView::use(const Seen& seen, double dt_s) {
  const double a = clamp(params.gain, 0.01, 1), b = a * a / (2 - a);  // critically damped, nearly
  for (std::size_t i = 0; i < 2; ++i) {
    const double off = seen.offset_m[i] - offset_m_[i];
    offset_m_[i] += a * off;
    offset_mps_[i] += b / dt_s * off;
  }
  const double off = seen.height_m - height_m_;
  height_m_ += a * off;
  height_mps_ += b / dt_s * off;
}

void LandingView::see(const msg::PadSighting& s, const msg::NavState& nav) {
  const bool first = stamp_ == msg::Time{};
  const double dt_s = first ? 0 : msg::seconds(s.stamp - stamp_);
  if (!first && dt_s <= 0) return;
  stamp_ = s.stamp;
  Seen seen;
  const bool measured = blind_ == 0 && measure(s, nav, seen);
  if (known_ == 0 || dt_s > kMostGap_s) {
    known_ = blind_ = 0;
    if (!measured) return;
    offset_m_ = seen.offset_m;
    height_m_ = seen.height_m;
    offset_mps_ = {-nav.v_world_mps.x, -nav.v_world_mps.y};
    height_mps_ = nav.v_world_mps.z;
    unseen_s_ = 0;
    known_ = 1;
    return;
  }
  if (!measured) {
    offset_mps_ = {-nav.v_world_mps.x, -nav.v_world_mps.y};
    height_mps_ = nav.v_world_mps.z;
  }
  for (std::size_t i = 0; i < 2; ++i) offset_m_[i] += offset_mps_[i] * dt_s;
  height_m_ += height_mps_ * dt_s;
  if (measured) use(seen, dt_s);
  unseen_s_ = measured ? 0 : unseen_s_ + dt_s;
  if (height_m_ < params.blind_below_m)
    blind_ = 1;
  else if (height_m_ > kSeesAgain * params.blind_below_m)
    blind_ = 0;
  if (blind_ == 0 && unseen_s_ > params.lost_s) known_ = 0;
}

}  // namespace sinew::control
