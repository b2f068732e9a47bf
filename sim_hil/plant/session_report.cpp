#include "sim_hil/plant/session_report.hpp"
#include "sim_hil/worlds/json_object.hpp"
#include "sim_hil/worlds/verdict_json.hpp"

namespace sinew::plant {
namespace {

std::string fault_json(const FaultLog::Entry& e) {
  JsonObject j;
  j.text("fault", to_string(e.fault));
  j.text("device", std::string(to_string(e.fault.device)));
  j.text("kind", std::string(to_string(e.fault.kind)));
  j.number("from_s", 1e-9 * static_cast<double>(e.fault.from_ns));
  if (e.fault.until_ns != kNoEnd) j.number("until_s", 1e-9 * static_cast<double>(e.fault.until_ns));
  j.integer("affected", e.affected);
  if (e.affected > 0) j.number("first_s", msg::seconds(e.first));
  return j.done();
}

std::string radio_json(const Air::Counts& counts) {
  JsonObject j;
  j.integer("sent", counts.sent);
  j.integer("heard", counts.heard);
  j.integer("tx_lost", counts.tx_lost);
  j.integer("rx_lost", counts.rx_lost);
  j.integer("out_of_reach", counts.out_of_reach);
  j.integer("rx_full", counts.rx_full);
  return j.done();
}

}  // namespace

std::string SessionReport::json(const SimRobot& robot) const {
  JsonObject j;
  j.boolean("valid", true);  // the measured values follow; the runtime's bounds judge them
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
  j.number("plant_s", plant_s);
  j.text("world", std::string(world_name));
  if (!robot_name.empty()) {
    j.text("robot", robot_name);
    j.object("radio", radio_json(radio));
  }
  j.boolean("still", robot.still());
  j.object("verdict", verdict_json(robot.verdict()));
  robot.add_to(j);
  std::vector<std::string> list;
  for (const FaultLog::Entry& e : faults) list.push_back(fault_json(e));
  j.list("faults", list);
  return j.done();
}

}  // namespace sinew::plant
