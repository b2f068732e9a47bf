#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "apps/robot_file/world_report.hpp"
#include "sim_hil/board/sim_board.hpp"

namespace sinew::app {

/// Limits of losses and waits, within which a run on a simulator counts. Times are the robot's.
/// Source:  docs/hil.md says what each means and why it is what it is; `[sim.bounds]` of the robot file sets them.
struct ValidityBounds {
  double plant_gap_ms = 2;
  double arrival_gap_ms = 10;
  double late_ms = 2, late_percent = 0.1;
  std::int64_t lost = 0;
  double frames_late_percent = 1;
  std::int64_t commands_dropped = 0;
  double missed_percent = 0.1;
  double clock_ms = 2, drift_ppm = 200;
  double link_down_ms = 100;
};

/// Measurements of a run: by the plant, the board and the graph.
struct RunEvidence {
  bool real_time = false;
  double rate = 1;  // robot seconds per second
  WorldReport plant;
  sim_hil::SimStats board;
  std::uint64_t releases = 0, missed = 0;  // of the graph's threads; missed: met an unfinished cycle
};

/// One bound and what was measured against it.
struct Finding {
  std::string key;   // that of the bound; "plant" for the plant's own verdict
  std::string what;  // for people, with the number and its unit
  double value = 0, bound = 0;
  bool holds = true;
};

/// Longest time between two IMU samples leaving the plant, in the robot's time.
double imu_gap_max_s(const RunEvidence& run);

/// All findings about this run; the run is valid when every finding holds. Virtual time has no findings about real
/// time. What a device lost while it had a requested fault does not count.
std::vector<Finding> examine(const RunEvidence& run, const ValidityBounds& bounds);
/// The texts of the findings that do not hold.
std::vector<std::string> invalid_because(const std::vector<Finding>& findings);

}  // namespace sinew::app
