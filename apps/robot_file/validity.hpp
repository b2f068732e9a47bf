#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "apps/robot_file/world_report.hpp"
#include "sim_hil/board/sim_board.hpp"

namespace sinew::app {

/// What a run on a simulator may at most have lost and waited for to count. Times are the robot's.
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

/// What a run was like, from all sides.
struct RunEvidence {
  bool real_time = false;
  double rate = 1;  // robot seconds per second
  WorldReport plant;
  sim_hil::SimStats board;
  std::uint64_t releases = 0, missed = 0;  // of the graph's threads; missed: met an unfinished cycle
};

/// One bound and what was measured against it.
struct Finding {
  std::string key;   // that of the bound; "plant" for the plant's own word
  std::string what;  // for people, with the number and its unit
  double value = 0, bound = 0;
  bool holds = true;
};

/// Longest time between two IMU samples leaving the plant, as the robot had to live with it.
double imu_gap_max_s(const RunEvidence& run);

/// All that can be said about this run; it is valid when every finding holds. In virtual time what has to do with real
/// time is left out. What a device lost that had a fault was asked for, and is no reason.
std::vector<Finding> examine(const RunEvidence& run, const ValidityBounds& bounds);
/// The words of those that do not hold.
std::vector<std::string> invalid_because(const std::vector<Finding>& findings);

}  // namespace sinew::app
