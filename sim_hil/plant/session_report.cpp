#include <algorithm>
#include <cmath>
#include <cstdio>

#include "sim_hil/plant/session.hpp"

namespace sinew::plant {
namespace {

/// Builds one flat JSON object. Texts are ours or printable ASCII of the peer.
class Json {
 public:
  void number(const char* key, double value) {
    char text[64];
    std::snprintf(text, sizeof text, "%.9g", value);
    raw(key, std::isfinite(value) ? text : "null");
  }
  void integer(const char* key, std::uint64_t value) { raw(key, std::to_string(value)); }
  void boolean(const char* key, bool value) { raw(key, value ? "true" : "false"); }
  void text(const char* key, const std::string& value) {
    std::string quoted = "\"";
    for (const char c : value) {
      if (c == '"' || c == '\\') quoted += '\\';
      quoted += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
    raw(key, quoted + "\"");
  }
  void list(const char* key, const std::vector<std::string>& objects) {
    std::string all;
    for (const std::string& o : objects) all += (all.empty() ? "" : ",") + o;
    raw(key, "[" + all + "]");
  }
  std::string done() { return out_ + "}"; }

 private:
  void raw(const char* key, const std::string& value) {
    out_ += out_.size() > 1 ? "," : "";
    out_ += '"';
    out_ += key;
    out_ += "\":";
    out_ += value;
  }
  std::string out_ = "{";
};

std::string fault_json(const FaultLog::Entry& e) {
  Json j;
  j.text("fault", to_string(e.fault));
  j.text("device", std::string(to_string(e.fault.device)));
  j.text("kind", std::string(to_string(e.fault.kind)));
  j.number("from_s", 1e-9 * static_cast<double>(e.fault.from_ns));
  if (e.fault.until_ns != kNoEnd) j.number("until_s", 1e-9 * static_cast<double>(e.fault.until_ns));
  j.integer("affected", e.affected);
  return j.done();
}

}  // namespace

bool SessionReport::at_rest() const {
  // Contacts of the physics know no rolling friction: what has fallen on its side rocks for long.
  constexpr double kStill_mps = 0.15, kStill_radps = 2.0;
  const auto norm2 = [](const msg::Vec3& v) { return v.x * v.x + v.y * v.y + v.z * v.z; };
  return last.contact && norm2(last.v_world_mps) < kStill_mps * kStill_mps &&
         norm2(last.gyro_radps) < kStill_radps * kStill_radps;
}

bool SessionReport::motors_stopped() const {
  constexpr double kStill_radps = 0.01 * RotorParams{}.omega_max_radps;
  return std::ranges::all_of(last.omega_radps, [](double w) { return w < kStill_radps; });
}

double SessionReport::pad_distance_m() const {
  const msg::Vec3& p = last.p_world_m;
  return std::sqrt(p.x * p.x + p.y * p.y);
}

std::string SessionReport::json() const {
  Json j;
  j.boolean("valid", true);  // what it measured follows; whether that is good enough, the runtime's bounds say
  j.integer("imu_gap_max_ns", static_cast<std::uint64_t>(imu_gap_max_ns));
  j.integer("wake_late_max_ns", static_cast<std::uint64_t>(wake_late_max_ns));
  j.integer("work_max_ns", static_cast<std::uint64_t>(work_max_ns));
  j.integer("render_late", render_late);
  j.integer("steps_late", steps_late);
  j.integer("frames", frames);
  j.integer("lease_expiries", lease_expiries);
  j.integer("relinks", relinks);
  j.boolean("stopped_by_supervisor", stopped_by_supervisor);
  if (stopped_by_supervisor) j.number("stopped_at_s", msg::seconds(stopped_at));
  j.integer("stale_actuations", stale_actuations);
  j.integer("setpoint_age_max_ns", static_cast<std::uint64_t>(setpoint_age_max_ns));
  j.integer("seed", seed);
  j.number("mass_kg", mass_kg);
  j.number("plant_s", plant_s);
  j.boolean("flew", flight.flew);
  j.boolean("crashed", flight.crashed);
  j.boolean("touched_down", flight.touched_down);
  j.number("max_height_m", flight.max_height_m);
  if (flight.touched_down) {
    j.number("touchdown_s", msg::seconds(flight.touchdown_at));
    j.number("touchdown_speed_mps", flight.touchdown_speed_mps);
    j.number("touchdown_drift_mps", flight.touchdown_drift_mps);
    j.number("touchdown_error_m", flight.touchdown_error_m);
    j.number("landing_error_m", pad_distance_m());
  }
  j.number("pad_distance_m", pad_distance_m());
  j.boolean("on_pad", last.on_pad);
  j.number("height_m", last.p_world_m.z);
  j.number("battery_v", last.voltage_v);
  j.boolean("at_rest", at_rest());
  j.boolean("motors_stopped", motors_stopped());
  std::vector<std::string> list;
  for (const FaultLog::Entry& e : faults) list.push_back(fault_json(e));
  j.list("faults", list);
  return j.done();
}

}  // namespace sinew::plant
