#include "apps/robot_file/flight_report.hpp"

#include <nlohmann/json.hpp>

namespace sinew::app {

namespace {

/// Another plant's report may hold anything; what is not there stays empty.
FlightReport::Fault read_fault(const nlohmann::json& f) {
  const auto text = [&](const char* key) {
    const auto it = f.find(key);
    return it != f.end() && it->is_string() ? it->get<std::string>() : std::string();
  };
  const auto affected = f.find("affected");
  return {text("fault"), text("device"),
          affected != f.end() && affected->is_number_unsigned() ? affected->get<std::uint64_t>() : 0};
}

}  // namespace

std::optional<FlightReport> parse_report(const std::string& json) {
  const auto j = nlohmann::json::parse(json, nullptr, false);
  if (!j.is_object()) return std::nullopt;
  const auto number = [&](const char* key) {
    const auto it = j.find(key);
    return it != j.end() && it->is_number() ? it->get<double>() : 0.0;
  };
  const auto flag = [&](const char* key) {
    const auto it = j.find(key);
    return it != j.end() && it->is_boolean() && it->get<bool>();
  };
  FlightReport r;
  r.valid = flag("valid");
  if (const auto it = j.find("reason"); it != j.end() && it->is_string()) r.reason = it->get<std::string>();
  r.touched_down = flag("touched_down");
  r.crashed = flag("crashed");
  r.landing_error_m = number("landing_error_m");
  r.touchdown_speed_mps = number("touchdown_speed_mps");
  r.touchdown_s = number("touchdown_s");
  if (j.contains("at_rest")) r.still = flag("at_rest") && flag("motors_stopped");
  r.imu_gap_max_s = number("imu_gap_max_ns") * 1e-9;
  r.frames = static_cast<std::uint64_t>(number("frames"));
  r.render_late = static_cast<std::uint64_t>(number("render_late"));
  if (j.contains("acquired"))
    r.follow = {flag("acquired"),       number("in_view_share"),     number("angle_rms_deg"), number("level_rms_deg"),
                number("roll_rms_deg"), number("base_tilt_rms_deg"), number("longest_loss_s")};
  if (const auto it = j.find("faults"); it != j.end() && it->is_array())
    for (const auto& f : *it)
      if (f.is_object()) r.faults.push_back(read_fault(f));
  return r;
}

bool FlightReport::is_faulty(const std::string& device) const {
  for (const Fault& f : faults)
    if (f.device == device || f.device == "link") return true;
  return false;
}

bool soft_landing(const FlightReport& report) {
  return report.touched_down && !report.crashed && report.touchdown_speed_mps < kGoodTouchdownSpeed_mps;
}

bool good_landing(const FlightReport& report) {
  return soft_landing(report) && report.landing_error_m < kGoodLandingError_m;
}

bool good_following(const FollowReport& report) {
  return report.acquired && report.in_view_share >= kGoodInViewShare && report.angle_rms_deg < kGoodAngle_deg;
}

}  // namespace sinew::app
