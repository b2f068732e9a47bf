#pragma once
#include <optional>
#include <string>
#include <vector>

#include "apps/flight/estimate_error.hpp"
#include "apps/robot_file/world_report.hpp"

namespace sinew::app {

/// What a run knows about an outcome that is not good.
struct MissEvidence {
  const WorldReport* report = nullptr;
  std::string unfinished{};              // where a mission was that is not done: "climbing"; empty: done, or none
  std::string ended_early{};             // "interrupted": somebody ended the run; empty: nobody did
  double ended_s = 0;                    // when the run ended
  std::vector<std::string> failsafes{};  // that acted, by name
  std::optional<double> saturated{};     // MissionWatch::saturated(); nothing: the robot has no actuators
  std::optional<EstimateError::Result> estimate{};
  bool real_time = false;
  double frames_late_percent_bound = 1;
};

/// One line: what missed by how much, and the most probable cause. A cause is, in this order: a failsafe that acted, a
/// fault that the plant played, or the measured condition that is farthest beyond its limit (as a multiple of it): the
/// world's own (wind, ...), actuators at their limits for more than 1 % of the time, an estimate that is off by more
/// than 0.1 m, late frames. Where none is beyond its limit, the line says what was measured instead. A mission that
/// somebody ended has missed nothing: then the line says in which phase it was.
std::string miss_cause(const MissEvidence& evidence);

}  // namespace sinew::app
