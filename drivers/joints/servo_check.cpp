#include "drivers/joints/servo_check.hpp"

#include <cmath>

namespace sinew::drivers {
namespace {

constexpr double kFeedbackPaces = 2.5, kLifePaces = 3;  // a time-out is at least so many periods

double ms(Duration d) { return msg::seconds(d) * 1e3; }
/// The shortest time-out for what comes at this pace.
double least_ms(const Pace& pace, double paces) { return paces * ms(pace.every); }
std::string because(const char* what, const Pace& pace) {
  return std::string(", as ") + what + " come every " + key_number(ms(pace.every)) + " ms (" + pace.key + ")";
}

}  // namespace

std::string to_string(const WrongKeys& all) {
  std::string text;
  for (const WrongKey& w : all) text += (text.empty() ? "" : "; ") + w.key + ": " + w.allowed;
  return text;
}

WrongKeys check_servo(const ServoConfig& c, bool derates_speed) {
  WrongKeys wrong;
  const ServoLimits& l = c.limits;
  if (c.sign != 1 && c.sign != -1) wrong.push_back({"reversed", "a sign of 1 or -1"});
  if (!(c.gear_ratio > 0) || !std::isfinite(c.gear_ratio)) wrong.push_back({"gear_ratio", "a number above 0"});
  if (!std::isfinite(c.zero_rad)) wrong.push_back({"zero_rad", "a number"});
  if (!(l.position_min_rad < l.position_max_rad))
    wrong.push_back({"max_rad", "a number above min_rad, " + key_number(l.position_min_rad)});
  if (!(l.velocity_radps > 0) || !std::isfinite(l.velocity_radps))
    wrong.push_back({"max_velocity_radps", "a number above 0"});
  if (!(l.effort_nm > 0)) wrong.push_back({"max_effort_nm", "a number above 0"});
  if (!derates_speed && c.derating.start_c < c.derating.end_c && !std::isfinite(l.effort_nm))
    wrong.push_back({"max_effort_nm", "a number above 0; required with derate_start_c and derate_end_c"});
  if (c.following.time <= Duration{0}) wrong.push_back({"following_time_ms", "a number above 0"});
  for (const auto& [key, gain] : {std::pair{"kp", c.kp}, {"kd", c.kd}, {"damp_kd", c.damp_kd}})
    if (!(gain >= 0)) wrong.push_back({key, "a number not below 0"});
  if (c.feedback_timeout <= Duration{0}) wrong.push_back({"feedback_timeout_ms", "a number above 0"});
  if (c.device_timeout < Duration{0}) wrong.push_back({"device_timeout_ms", "a number not below 0"});
  return wrong;
}

WrongKeys check_times(const ServoConfig& c, const Pace& feedback, const Pace& life) {
  WrongKeys wrong;
  if (const double least = least_ms(feedback, kFeedbackPaces); ms(c.feedback_timeout) < least)
    wrong.push_back({"feedback_timeout_ms", "at least " + key_number(least) + because("its answers", feedback)});
  if (const double least = least_ms(life, kLifePaces); c.device_timeout > Duration{0} && ms(c.device_timeout) < least)
    wrong.push_back({"device_timeout_ms",
                     "0 (as the drive is set) or at least " + key_number(least) + because("our signs of life", life)});
  return wrong;
}

}  // namespace sinew::drivers
