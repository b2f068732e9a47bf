// Ranges, batteries, satellite fixes, pressure and remote control.
#include <algorithm>
#include <cmath>
#include <limits>

#include "msg/sensors.hpp"
#include "net/ros2/pair_code.hpp"

namespace sinew::ros2::detail {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

constexpr double kStandardTemperatureC = 15;  // ISO 2533 at sea level

}  // namespace

bool write_range(const Context& c, const void* own) {
  const double range = static_cast<const msg::RangeSample*>(own)->range_m;
  at(c, "field_of_view").set(c.options.field_of_view_rad);
  at(c, "min_range").set(c.options.min_m);
  at(c, "max_range").set(c.options.max_m);
  at(c, "range").set(std::isnan(range) ? kInfinity : range);
  return true;
}
const char* read_range(const Context& c, void* own) {
  const double range = at(c, "range").number();
  if (!math::is_finite(range) || range < at(c, "min_range").number() || range > at(c, "max_range").number())
    return kNothing;
  static_cast<msg::RangeSample*>(own)->range_m = range;
  return nullptr;
}

bool write_battery(const Context& c, const void* own) {
  const auto& battery = *static_cast<const msg::BatterySample*>(own);
  constexpr double kDischarging = 2, kCharging = 1, kUnknown = 0;
  at(c, "power_supply_status")
      .set_integer(static_cast<std::int64_t>(battery.current_a > 0   ? kDischarging
                                             : battery.current_a < 0 ? kCharging
                                                                     : kUnknown));
  at(c, "voltage").set(battery.voltage_v);
  at(c, "current").set(-battery.current_a);
  at(c, "percentage").set(battery.charge);
  for (const char* unknown : {"temperature", "charge", "capacity", "design_capacity"}) at(c, unknown).set(kNan);
  return true;
}
const char* read_battery(const Context& c, void* own) {
  auto& battery = *static_cast<msg::BatterySample*>(own);
  const auto voltage = finite(at(c, "voltage")), charge = finite(at(c, "percentage"));
  if (!voltage) return "voltage is not known";
  if (!charge) return "percentage is not known";
  battery.voltage_v = *voltage;
  battery.charge = *charge;
  battery.current_a = -finite(at(c, "current")).value_or(0);
  return nullptr;
}

bool write_fix(const Context& c, const void* own) {
  const auto& g = *static_cast<const msg::GnssSample*>(own);
  constexpr std::int64_t kNoFix = -1, kFix = 0, kGbas = 2, kGps = 1;
  std::int64_t status = kNoFix;
  if (g.fix == msg::GnssFix::flat || g.fix == msg::GnssFix::full) status = kFix;
  if (g.fix == msg::GnssFix::rtk_float || g.fix == msg::GnssFix::rtk_fixed) status = kGbas;
  at(c, "status.status").set_integer(status);
  at(c, "status.service").set_integer(kGps);
  at(c, "altitude").set(g.altitude_m + c.options.geoid_m);  // NaN without: the altitude is not known
  const double h2 = g.horizontal_accuracy_m * g.horizontal_accuracy_m,
               v2 = g.vertical_accuracy_m * g.vertical_accuracy_m;
  const bool known = math::is_finite(h2) && math::is_finite(v2);
  for (Value& v : at(c, "position_covariance").items) v.set(0);
  at(c, "position_covariance[0]").set(known ? h2 : 0);
  at(c, "position_covariance[4]").set(known ? h2 : 0);
  at(c, "position_covariance[8]").set(known ? v2 : 0);
  at(c, "position_covariance_type").set_integer(known ? 1 : 0);  // approximated; unknown
  return true;
}
const char* read_fix(const Context& c, void* own) {
  auto& g = *static_cast<msg::GnssSample*>(own);
  if (at(c, "status.status").integer() < 0) return kNothing;
  const auto altitude = finite(at(c, "altitude"));
  if (!altitude) return "altitude is not known";
  g.altitude_m = *altitude - c.options.geoid_m;
  g.fix = at(c, "status.status").integer() == 2 ? msg::GnssFix::rtk_float : msg::GnssFix::full;
  const bool known = at(c, "position_covariance_type").integer() != 0;
  const auto accuracy = [&](const char* path) {
    const double variance = at(c, path).number();
    return known && variance >= 0 && math::is_finite(variance) ? math::sqrt(variance) : kNoIdea;
  };
  g.horizontal_accuracy_m = accuracy("position_covariance[0]");
  g.vertical_accuracy_m = accuracy("position_covariance[8]");
  g.speed_accuracy_mps = kNoIdea;
  return nullptr;
}

const char* read_pressure(const Context&, void* own) {
  static_cast<msg::BaroSample*>(own)->temperature_c = kStandardTemperatureC;
  return nullptr;
}

const char* read_joy(const Context& c, void* own) {
  auto& rc = *static_cast<msg::RcSample*>(own);
  const auto add = [&rc](double value) {
    if (rc.count < msg::kMaxRcChannels) rc.channel[rc.count++] = value;
  };
  for (const Value& axis : at(c, "axes").items) {
    const auto number = finite(axis);
    if (!number) return "an axis that is not finite";
    add(std::clamp(*number, -1.0, 1.0));
  }
  for (const Value& button : at(c, "buttons").items) add(button.integer() != 0 ? 1 : -1);
  rc.link_quality = 1;
  return nullptr;
}

}  // namespace sinew::ros2::detail
