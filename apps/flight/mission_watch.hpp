#pragma once
// Watches from outside what a flying robot publishes about itself.
#include <optional>
#include <string>
#include <vector>

#include "hal/clock.hpp"
#include "msg/flight.hpp"
#include "msg/safety.hpp"
#include "rt/graph.hpp"
#include "rt/latch.hpp"

namespace sinew::app {

/// Reads the states of the mission and the guardian, where the robot has them, at a priority below the loops.
/// Thread:  owner, one.
class MissionWatch {
 public:
  /// Names the topics for Graph::configure(); empty when the graph has neither.
  static std::vector<std::string> taps(const rt::Graph& graph);
  explicit MissionWatch(rt::Graph& graph);  // after configure()
  /// Reads them again. Null: no mission, or no state published yet.
  const msg::MissionState* look();
  /// There is a mission.
  bool exists() const { return mission_; }
  /// As of the last look(): the mission is done, or the guardian has been safe for so long that nothing more will move.
  /// False for a robot without a mission.
  bool ended() const;
  /// The guardian's last state.
  const msg::SafetyState& safety() const { return last_safety_; }

 private:
  std::optional<rt::Latch> latch_;
  rt::In<msg::MissionState> port_;
  rt::In<msg::SafetyState> safety_port_;
  msg::MissionState last_;
  msg::SafetyState last_safety_;
  msg::Time calm_;  // when the guardian was last seen not safe
  bool any_ = false, mission_ = false;
};

const char* to_string(msg::MissionPhase phase);

/// When a flight in a simulator is over: the mission has ended, and since then the vehicle has lain still for a moment,
/// or enough time has passed for it to come down.
class FlightEnd {
 public:
  explicit FlightEnd(MissionWatch& mission) : mission_(mission) {}
  /// `report`: the plant's latest, JSON; empty: none yet. Thread: owner.
  bool reached(rt::Time now, const std::string& report);

 private:
  MissionWatch& mission_;
  rt::Time mission_end_ = hal::kNever, still_since_ = hal::kNever;
};

}  // namespace sinew::app
