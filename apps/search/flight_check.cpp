#include "apps/search/flight_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace sinew::search {
namespace {

constexpr double kAirborneM = 0.3;              // of the base: feet 0.18 m above the ground
constexpr msg::Duration kFallFor{50'000'000};   // of falling before it is judged
constexpr msg::Duration kSameTime{15'000'000};  // an estimate is compared with a truth at most so much later

/// The world's up direction in the base frame.
msg::Vec3 up_base(const msg::Quat& q) {
  return {2 * (q.x * q.z - q.w * q.y), 2 * (q.y * q.z + q.w * q.x), 1 - 2 * (q.x * q.x + q.y * q.y)};
}

double angle(const msg::Vec3& a, const msg::Vec3& b) {
  return std::acos(std::clamp(a.x * b.x + a.y * b.y + a.z * b.z, -1.0, 1.0));
}

}  // namespace

FlightCheck::FlightCheck(const Case& c, const Excuses& excused, const Limits& limits, Verdict& verdict)
    : case_(c), limits_(limits), excuses_(excused), verdict_(verdict) {}

void FlightCheck::truth(msg::Time at, const sim_hil::Truth& truth, msg::Time command_valid_until) {
  airborne_ = !truth.contact && truth.p_world_m.z > kAirborneM;
  flew_ |= airborne_;
  const double tilt = angle(up_base(truth.q_world_base), {0, 0, 1});
  // Also below the height at which tilt is judged: the vehicle bumps on the ground, and its estimate is then a guess.
  if (flew_ && !truth.contact && command_valid_until < at && excuses_.failsafe) fell_ = true;
  if (airborne_ && !fell_) {
    worst_.tilt_rad = std::max(worst_.tilt_rad, tilt);
    if (tilt > limits_.tilt_rad && !excuses_.failsafe)
      verdict_.fail("tilt", at, fmt::format("{:.2f} rad, at most {:.2f}", tilt, limits_.tilt_rad));
  }
  check_fall(at, truth, command_valid_until);
  last_ = truth;
  last_at_ = at;
}

void FlightCheck::check_fall(msg::Time at, const sim_hil::Truth& truth, msg::Time command_valid_until) {
  if (!airborne_ || at - command_valid_until < limits_.spin_down) {
    free_since_ = msg::Time{-1};
    return;
  }
  if (free_since_.ns < 0) {
    free_since_ = at;
    free_from_mps_ = truth.v_world_mps.z;
    return;
  }
  if (at - free_since_ < kFallFor) return;
  const double accel = (truth.v_world_mps.z - free_from_mps_) / msg::seconds(at - free_since_);
  // A body that has fallen for long is slowed by the air; only the first metres per second are judged.
  if (accel > -limits_.fall_mps2 && truth.v_world_mps.z > -4)
    verdict_.fail("thrust", at,
                  fmt::format("{:.0f} ms after the last command ended it accelerates with {:.1f} m/s^2",
                              1e3 * msg::seconds(at - command_valid_until), accel));
}

void FlightCheck::estimate(const msg::NavState& s) {
  if (last_at_.ns < 0 || last_at_ < s.stamp || last_at_ - s.stamp > kSameTime) return;
  if (fell_ || case_.disturbed(last_at_, limits_.recovery) || case_.lied_to(last_at_)) return;
  if (s.attitude_valid) {
    const double error = angle(up_base(s.q_world_base), up_base(last_.q_world_base));
    worst_.tilt_error_rad = std::max(worst_.tilt_error_rad, error);
    if (error > limits_.tilt_error_rad)
      verdict_.fail("estimate", last_at_,
                    fmt::format("tilt is off by {:.3f} rad, at most {:.3f}", error, limits_.tilt_error_rad));
  }
  if (s.height_valid && airborne_) {
    const double error = std::fabs(s.height_m - last_.p_world_m.z);
    worst_.height_error_m = std::max(worst_.height_error_m, error);
    if (error > limits_.height_error_m)
      verdict_.fail("estimate", last_at_,
                    fmt::format("height is off by {:.2f} m, at most {:.2f}", error, limits_.height_error_m));
  }
}

void FlightCheck::guardian(msg::Time now, std::uint32_t faults) {
  failsafe_acted_ |= faults != 0;
  if (faults != 0 && !excuses_.failsafe)
    verdict_.fail("failsafe", now, fmt::format("the guardian acts on faults {:#x}", faults));
}

}  // namespace sinew::search
