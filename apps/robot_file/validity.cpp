#include "apps/robot_file/validity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace sinew::app {
namespace {

using sim_hil::DeviceKind;
using sim_hil::DeviceStats;

double ms(hal::Duration d) { return msg::seconds(d) * 1e3; }
double percent(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 0 : 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}

class Examiner {
 public:
  Examiner(const RunEvidence& run, const ValidityBounds& bounds) : run_(run), bounds_(bounds) {}

  std::vector<Finding> all() {
    if (!run_.plant.valid)
      add("plant", "the plant says: " + (run_.plant.reason.empty() ? "no reason" : run_.plant.reason), 1, 0);
    for (const DeviceStats& d : run_.board.devices) device(d);
    if (run_.real_time) real_time();
    return std::move(out_);
  }

 private:
  void add(const char* key, std::string what, double value, double bound) {
    out_.push_back({key, std::move(what), value, bound, value <= bound});
  }

  void device(const DeviceStats& d) {
    if (run_.plant.is_faulty(d.name)) return;
    if (d.kind == DeviceKind::actuators) return;  // commands are counted below
    if (const auto n = d.lost + d.overflow; n > 0)
      add("lost", fmt::format("{}: {} samples lost, {} overwritten", d.name, d.lost, d.overflow), n,
          static_cast<double>(bounds_.lost));
    if (!run_.real_time) {
      if (d.late > 0) add("late_percent", fmt::format("{}: {} samples after their grant", d.name, d.late), d.late, 0);
      return;
    }
    const double late = percent(d.late, d.samples);
    add("late_percent", fmt::format("{}: {:.2f} % of {} samples came late", d.name, late, d.samples), late,
        bounds_.late_percent);
    const double beyond = ms(d.max_gap_arrival - d.max_gap_stamp);
    add("arrival_gap_ms",
        fmt::format("{}: {:.2f} ms between two arrivals, {:.2f} ms between their stamps at most", d.name,
                    ms(d.max_gap_arrival), ms(d.max_gap_stamp)),
        beyond, bounds_.arrival_gap_ms);
  }

  void real_time() {
    const double gap = imu_gap_max_s(run_) * 1e3;
    add("plant_gap_ms", fmt::format("plant: {:.2f} ms between two IMU samples leaving", gap), gap,
        bounds_.plant_gap_ms);
    const double drawn_late = percent(run_.plant.render_late, run_.plant.frames + run_.plant.render_late);
    add("frames_late_percent", fmt::format("plant: {:.1f} % of its frames late or left out", drawn_late), drawn_late,
        bounds_.frames_late_percent);
    add("commands_dropped", fmt::format("{} commands that the plant did not take in time", run_.board.commands_dropped),
        run_.board.commands_dropped, static_cast<double>(bounds_.commands_dropped));
    const double missed = percent(run_.missed, run_.releases);
    add("missed_percent", fmt::format("{} missed deadlines, {:.3f} % of all releases", run_.missed, missed), missed,
        bounds_.missed_percent);
    if (run_.board.remote) clock();
    for (const auto& o : run_.board.outages)
      add("link_down_ms", fmt::format("without a plant for {:.0f} ms: {}", ms(o.length), o.why), ms(o.length),
          bounds_.link_down_ms);
  }

  void clock() {
    const sim_hil::ClockStats& c = run_.board.clock;
    add("clock_ms",
        fmt::format("clock of the plant known to {:.3f} ms{}", ms(c.worst_bound),
                    c.followed ? fmt::format(" by {} exchanges", c.exchanges) : ", not followed: no side line"),
        ms(c.worst_bound), bounds_.clock_ms);
    add("drift_ppm", fmt::format("clock of the plant drifts by {:+.1f} ppm", c.drift * 1e6), std::abs(c.drift) * 1e6,
        bounds_.drift_ppm);
    if (c.restarts > 0) add("clock_ms", fmt::format("clock of the plant jumped {} times", c.restarts), c.restarts, 0);
  }

  const RunEvidence& run_;
  const ValidityBounds& bounds_;
  std::vector<Finding> out_;
};

}  // namespace

double imu_gap_max_s(const RunEvidence& run) { return run.plant.imu_gap_max_s * run.rate; }

std::vector<Finding> examine(const RunEvidence& run, const ValidityBounds& bounds) {
  return Examiner(run, bounds).all();
}

const Finding* worst_of(const std::vector<Finding>& findings) {
  const auto beyond = [](const Finding& f) {
    if (f.key == "plant") return std::numeric_limits<double>::infinity();
    return f.bound > 0 ? f.value / f.bound : f.value;
  };
  const Finding* worst = nullptr;
  for (const Finding& f : findings)
    if (!f.holds && (!worst || beyond(f) > beyond(*worst))) worst = &f;
  return worst;
}

std::string what_to_do(const Finding& finding, bool real_time, const std::string& robot) {
  const std::string_view key = finding.key;
  if (key == "plant") return "that is the simulator's own word: look into its report";
  if (key == "clock_ms" || key == "drift_ppm") return "the clocks of the two machines: docs/hil.md";
  if (key == "link_down_ms") return "the connection to the plant was gone: look at the network and the plant";
  if (!real_time) return "the simulator or the robot's queues are at fault: docs/hil.md";
  return "the machine's doing: `sinew doctor " + robot + "` says what to change";
}

std::vector<std::string> invalid_because(const std::vector<Finding>& findings) {
  std::vector<std::string> reasons;
  for (const Finding& f : findings)
    if (!f.holds)
      reasons.push_back(f.key == "plant" ? f.what : fmt::format("{}; the bound is {} = {:g}", f.what, f.key, f.bound));
  return reasons;
}

}  // namespace sinew::app
