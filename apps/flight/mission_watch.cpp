#include "apps/flight/mission_watch.hpp"

#include "apps/robot_file/world_report.hpp"

namespace sinew::app {
namespace {

using namespace std::chrono_literals;

constexpr const char* kGuardianState = "guardian.state";
constexpr msg::Duration kSafeForGood = 3s;      // a fall from the search height takes less
constexpr msg::Duration kAfterMission = 300ms;  // so that the report covers the rest on the ground
constexpr msg::Duration kSettles = 5s;          // a vehicle in the air at the end of the mission is down by then

}  // namespace

std::vector<std::string> MissionWatch::taps(const rt::Graph& graph) {
  std::vector<std::string> names;
  for (const auto& topic : graph.topics())
    if (topic.type == &msg::type_info<msg::MissionState>()) {
      names.push_back(topic.name);
      break;
    }
  if (graph.find_topic(kGuardianState) != rt::kNone) names.emplace_back(kGuardianState);
  return names;
}

MissionWatch::MissionWatch(rt::Graph& graph) {
  if (graph.taps().empty()) return;
  latch_.emplace(graph.segment());
  const std::vector<std::string> names = taps(graph);
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == kGuardianState) {
      latch_->bind(safety_port_, graph.taps()[i]);
    } else {
      latch_->bind(port_, graph.taps()[i]);
      mission_ = true;
    }
  }
}

const msg::MissionState* MissionWatch::look() {
  if (!latch_) return nullptr;
  latch_->latch();
  if (const auto* state = port_.get()) {
    last_ = *state;
    any_ = true;
  }
  if (const auto* safety = safety_port_.get()) {
    last_safety_ = *safety;
    const bool over = safety->mode == msg::GuardianMode::safe && safety->groups_moving == 0;
    if (!over || calm_.ns == 0) calm_ = safety->stamp;
  }
  latch_->release();
  return any_ ? &last_ : nullptr;
}

bool MissionWatch::ended() const {
  if (!mission_) return false;
  return last_.phase == msg::MissionPhase::done || last_safety_.stamp - calm_ > kSafeForGood;
}

bool FlightEnd::reached(rt::Time now, const std::string& report) {
  mission_.look();
  if (!mission_.ended()) {
    mission_end_ = hal::kNever;
    return false;
  }
  if (mission_end_ == hal::kNever) mission_end_ = still_since_ = now;
  // A rocking body is still for a moment each time it turns back.
  if (const auto told = parse_report(report); told && !told->still) still_since_ = now;
  return now - still_since_ >= kAfterMission || now - mission_end_ >= kSettles;
}

const char* to_string(msg::MissionPhase phase) {
  using P = msg::MissionPhase;
  switch (phase) {
    case P::wait:
      return "waiting";
    case P::arm:
      return "arming";
    case P::climb:
      return "climbing";
    case P::search:
      return "searching the pad";
    case P::approach:
      return "approaching the pad";
    case P::hold:
      return "holding above the pad";
    case P::descend:
      return "descending";
    case P::touchdown:
      return "touching down";
    case P::done:
      return "done";
    case P::abort:
      return "aborted";
  }
  return "?";
}

}  // namespace sinew::app
