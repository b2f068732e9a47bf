#pragma once
// What all ways of running share: the robot, its graph, and what is watched from outside.
#include <memory>
#include <optional>
#include <string>

#include "apps/robot_file.hpp"
#include "apps/run_command.hpp"
#include "msg/flight.hpp"
#include "rt/graph.hpp"
#include "rt/latch.hpp"
#include "rt/module_types.hpp"
#include "rt/real_time_executor.hpp"

namespace sinew::app {

/// A robot file with the options applied and its graph checked.
struct Prepared {
  RobotFile robot;
  rt::ModuleTypes types;
  std::unique_ptr<rt::Graph> graph;
};

/// Prints every problem to standard error; empty when there was one.
std::optional<Prepared> prepare(const RunOptions& options, const rt::ModuleTypes& types);

/// --duration as a duration.
rt::Duration run_duration(const RunOptions& options);

/// For this machine, on a clock of this rate.
rt::RealTimeOptions real_time_options(double rate = 1);

/// Prints what a real-time run could not have. False when `strict` forbids to go on.
bool accept_shortfalls(const std::vector<std::string>& shortfalls, bool strict);

/// Applies "module.param=value"; the reason when it cannot.
std::string apply_setting(rt::GraphSpec& graph, const std::string& setting);

/// Reads the mission's state, if the robot has one, below the loops: never in their way.
/// Thread:  owner, one.
class MissionWatch {
 public:
  /// Names the topic for Graph::configure(); empty when the graph has no mission.
  static std::vector<std::string> taps(const rt::Graph& graph);
  explicit MissionWatch(rt::Graph& graph);  // after configure()
  /// Looks again. Null: no mission, or nothing said yet.
  const msg::MissionState* look();
  bool exists() const { return latch_.has_value(); }
  bool ended() const { return last_.phase == msg::MissionPhase::done || last_.phase == msg::MissionPhase::abort; }

 private:
  std::optional<rt::Latch> latch_;
  rt::In<msg::MissionState> port_;
  msg::MissionState last_;
  bool any_ = false;
};

const char* to_string(msg::MissionPhase phase);

}  // namespace sinew::app
