#pragma once
// Watches from outside what a robot publishes about itself.
#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/flight/estimate_error.hpp"
#include "apps/flight/mission_events.hpp"
#include "hal/clock.hpp"
#include "msg/flight.hpp"
#include "msg/safety.hpp"
#include "rt/graph.hpp"
#include "rt/latch.hpp"
#include "rt/slot_reader.hpp"

namespace sinew::app {

/// Every message of a tapped topic since the last look, as far back as the topic's history goes.
/// Thread:  owner, one.
template <msg::Described M>
class Followed {
 public:
  Followed(rt::Latch& latch, rt::Segment& segment, rt::ConnectionId tap) : past_(segment, tap) {
    latch.bind(port_, tap);
  }
  /// Between latch() and release().
  void take() {
    fresh_ = port_.get() && (!any_ || port_.updated());
    if (!fresh_) return;
    back_ = any_ ? port_.header(0)->sequence - sequence_ : 1;
    sequence_ = port_.header(0)->sequence;
    newest_ = *port_.get();
    any_ = true;
  }
  /// After release(), which gives back the one pin that this tap may have: each new message, oldest first.
  template <class Each>
  void each(const Each& each) {
    if (!fresh_) return;
    for (std::uint32_t i = std::min(back_, kMostBack) - 1; i > 0; --i)
      if (const rt::SlotHeader* const slot = past_.pin(sequence_ - i)) {
        each(*static_cast<const M*>(slot->message()));
        past_.unpin();
      }
    each(newest_);
  }
  bool any() const { return any_; }
  const M& newest() const { return newest_; }

 private:
  static constexpr std::uint32_t kMostBack = 4096;
  rt::In<M> port_;
  rt::SlotReader past_;
  M newest_{};
  std::uint32_t sequence_ = 0, back_ = 0;
  bool any_ = false, fresh_ = false;
};

/// Reads the states of the mission and the guardian, where the robot has them, at a priority below the loops.
/// Thread:  owner, one.
class MissionWatch {
 public:
  /// Names the topics for Graph::configure(); empty when the graph has none of them.
  static std::vector<std::string> taps(const rt::Graph& graph);
  explicit MissionWatch(rt::Graph& graph);  // after configure()
  /// Reads them again, and everything that they said since the last look. Null: no mission, or no state published yet.
  const msg::MissionState* look();
  /// There is a mission.
  bool exists() const { return mission_.has_value(); }
  /// As of the last look(): the mission is done, or the guardian has been safe for so long that nothing more will move.
  /// False for a robot without a mission.
  bool ended() const;
  /// The guardian's last state.
  const msg::SafetyState& safety() const { return last_safety_; }

  using Event = MissionEvents::Event;
  /// Since the last call.
  std::vector<Event> take_events() { return events_.take(); }
  /// Share of the time with live actuators in which one of a group was at its limit, of the worst group; 0..1.
  double saturated() const;
  /// How far the estimate is from the simulator's truth; nothing: the robot lacks one of the two topics.
  std::optional<EstimateError::Result> estimate_error() const;

 private:
  /// What the guardian does to one actuator group.
  struct Group {
    Group(rt::Latch& latch, rt::Segment& segment, rt::ConnectionId tap, std::size_t of)
        : state(latch, segment, tap), actuator(of) {}
    Followed<msg::GuardianState> state;
    std::size_t actuator;  // index in the spec
    std::uint64_t live = 0, at_limit = 0;
  };
  void see(const msg::SafetyState& state);
  void see(Group& group, const msg::GuardianState& state);

  const rt::GraphSpec* spec_ = nullptr;
  std::optional<rt::Latch> latch_;
  std::optional<Followed<msg::MissionState>> mission_;
  std::optional<Followed<msg::SafetyState>> safety_;
  std::optional<Followed<msg::NavState>> estimate_, truth_;
  std::vector<std::unique_ptr<Group>> groups_;  // ports are bound by address
  EstimateError error_;
  MissionEvents events_;
  msg::SafetyState last_safety_;
  msg::Time calm_;  // when the guardian was last seen not safe
};

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
