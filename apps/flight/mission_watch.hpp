#pragma once
// Looks from outside at what a flying robot says about itself.
#include <optional>
#include <string>
#include <vector>

#include "hal/clock.hpp"
#include "msg/flight.hpp"
#include "msg/safety.hpp"
#include "rt/graph.hpp"
#include "rt/latch.hpp"

namespace sinew::app {

/// Reads the mission's and the guardian's state, as far as the robot has them, below the loops: never in their way.
/// Thread:  owner, one.
class MissionWatch {
 public:
  /// Names the topics for Graph::configure(); empty when the graph has neither.
  static std::vector<std::string> taps(const rt::Graph& graph);
  explicit MissionWatch(rt::Graph& graph);  // after configure()
  /// Looks again. Null: no mission, or nothing said yet.
  const msg::MissionState* look();
  /// There is a mission.
  bool exists() const { return mission_; }
  /// A mission is done, or stopped for so long that nothing more will move; a robot without one goes on. As of the
  /// last look().
  bool ended() const;
  /// What the guardian said last.
  const msg::SafetyState& safety() const { return last_safety_; }

 private:
  std::optional<rt::Latch> latch_;
  rt::In<msg::MissionState> port_;
  rt::In<msg::SafetyState> safety_port_;
  msg::MissionState last_;
  msg::SafetyState last_safety_;
  msg::Time calm_;  // the guardian was last seen otherwise than safe
  bool any_ = false, mission_ = false;
};

const char* to_string(msg::MissionPhase phase);

/// When a flight in a simulator is over: the mission has ended, and the vehicle lies still for a moment, or long enough
/// after the end that what is in the air has come down.
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
