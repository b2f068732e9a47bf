#pragma once
#include <optional>
#include <string>
#include <vector>

#include "apps/flight/story.hpp"
#include "msg/flight.hpp"
#include "msg/safety.hpp"
#include "rt/graph_spec.hpp"

namespace sinew::app {

/// What happened in a run, from the messages in which a robot says so: phases of its mission, failsafes, arming,
/// actuators that went to their safe action. Of a running robot and of a recording.
/// Thread:  owner.
/// Owner:   the spec outlives it.
class MissionEvents {
 public:
  struct Event {
    rt::Time at;  // by the stamps of the messages
    Story::Weight weight = Story::Weight::detail;
    std::string text{};
    bool alarm = false;  // something had to act: a failsafe, a safe action, whoever disarmed it in flight
  };
  explicit MissionEvents(const rt::GraphSpec& spec) : spec_(&spec), modes_(spec.actuators.size()) {}

  // Each message, oldest first.
  void see(const msg::MissionState& state);
  void see(const msg::SafetyState& state);
  /// `actuator`: index in the spec; of the topic state_topic().
  void see(std::size_t actuator, const msg::GuardianState& state);
  /// Since the last call.
  std::vector<Event> take();

  /// The guardian's topics.
  static constexpr const char* kSafetyTopic = "guardian.state";
  static std::string state_topic(const rt::ActuatorSpec& actuator) { return "guardian." + actuator.name; }

 private:
  const rt::GraphSpec* spec_;
  std::optional<msg::MissionPhase> phase_;
  msg::SafetyState safety_;
  std::vector<msg::GuardianMode> modes_;  // by actuator
  std::vector<Event> events_;
};

/// A phase in the words of the robot's mission: "searching the pad".
std::string phase_words(const rt::GraphSpec& spec, msg::MissionPhase phase);

}  // namespace sinew::app
