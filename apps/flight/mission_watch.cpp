#include "apps/flight/mission_watch.hpp"

#include <algorithm>
#include <span>

#include "apps/robot_file/world_report.hpp"

namespace sinew::app {
namespace {

using namespace std::chrono_literals;

constexpr const char* kGroundTruth = "ground_truth";  // of a simulator
constexpr msg::Duration kSafeForGood = 3s;            // a fall from the search height takes less
constexpr msg::Duration kAfterMission = 300ms;        // so that the report covers the rest on the ground
constexpr msg::Duration kSettles = 5s;                // a vehicle in the air at the end of the mission is down by then

template <class M>
std::string first_of(const rt::Graph& graph) {
  for (const auto& topic : graph.topics())
    if (topic.type == &msg::type_info<M>() && topic.name != kGroundTruth) return topic.name;
  return {};
}

/// The estimate's topic; empty where there is no truth to hold it against.
std::string estimate_topic(const rt::Graph& graph) {
  const std::uint32_t truth = graph.find_topic(kGroundTruth);
  const bool there = truth != rt::kNone && graph.topics()[truth].type == &msg::type_info<msg::NavState>();
  return there ? first_of<msg::NavState>(graph) : std::string();
}

}  // namespace

std::vector<std::string> MissionWatch::taps(const rt::Graph& graph) {
  std::vector<std::string> names;
  const auto add = [&](const std::string& name) {
    if (graph.find_topic(name) != rt::kNone) names.push_back(name);
  };
  add(first_of<msg::MissionState>(graph));
  add(MissionEvents::kSafetyTopic);
  for (const rt::ActuatorSpec& a : graph.spec().actuators) add(MissionEvents::state_topic(a));
  if (const std::string estimate = estimate_topic(graph); !estimate.empty()) {
    names.push_back(estimate);
    names.emplace_back(kGroundTruth);
  }
  return names;
}

MissionWatch::MissionWatch(rt::Graph& graph) : spec_(&graph.spec()), events_(graph.spec()) {
  if (graph.taps().empty()) return;
  latch_.emplace(graph.segment());
  const std::vector<std::string> names = taps(graph);
  const std::string mission = first_of<msg::MissionState>(graph);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const rt::ConnectionId tap = graph.taps()[i];
    const auto follow = [&](auto& followed) { followed.emplace(*latch_, graph.segment(), tap); };
    const auto group = std::ranges::find_if(spec_->actuators,
                                            [&](const auto& a) { return MissionEvents::state_topic(a) == names[i]; });
    if (names[i] == MissionEvents::kSafetyTopic)
      follow(safety_);
    else if (names[i] == mission)
      follow(mission_);
    else if (group != spec_->actuators.end())
      groups_.push_back(std::make_unique<Group>(*latch_, graph.segment(), tap,
                                                static_cast<std::size_t>(group - spec_->actuators.begin())));
    else
      follow(names[i] == kGroundTruth ? truth_ : estimate_);
  }
}

const msg::MissionState* MissionWatch::look() {
  if (!latch_) return nullptr;
  const auto followed = [this](const auto& act) {
    if (mission_) act(*mission_);
    if (safety_) act(*safety_);
    if (estimate_) act(*estimate_);
    if (truth_) act(*truth_);
    for (const auto& group : groups_) act(group->state);
  };
  latch_->latch();
  followed([](auto& f) { f.take(); });
  latch_->release();
  if (mission_) mission_->each([this](const msg::MissionState& state) { events_.see(state); });
  if (safety_) safety_->each([this](const msg::SafetyState& state) { see(state); });
  for (const auto& group : groups_) group->state.each([&](const msg::GuardianState& state) { see(*group, state); });
  if (estimate_ && truth_ && estimate_->any() && truth_->any()) error_.add(estimate_->newest(), truth_->newest());
  return mission_ && mission_->any() ? &mission_->newest() : nullptr;
}

void MissionWatch::see(const msg::SafetyState& state) {
  const bool over = state.mode == msg::GuardianMode::safe && state.groups_moving == 0;
  if (!over || calm_.ns == 0) calm_ = state.stamp;
  last_safety_ = state;
  events_.see(state);
}

void MissionWatch::see(Group& group, const msg::GuardianState& state) {
  events_.see(group.actuator, state);
  if (state.mode != msg::GuardianMode::active) return;
  const rt::ActuatorSpec& spec = spec_->actuators[group.actuator];
  const std::size_t n = std::min<std::size_t>(state.count, state.value.size());
  const auto values = std::span(state.value).first(n);
  const auto low = [&](double v) { return v <= spec.min; };
  const auto at_limit = [&](double v) { return low(v) || v >= spec.max; };
  ++group.live;
  group.at_limit += std::ranges::any_of(values, at_limit) && !std::ranges::all_of(values, low);  // all low: idle
}

double MissionWatch::saturated() const {
  double most = 0;
  for (const auto& group : groups_)
    if (group->live > 0) most = std::max(most, static_cast<double>(group->at_limit) / static_cast<double>(group->live));
  return most;
}

std::optional<EstimateError::Result> MissionWatch::estimate_error() const { return error_.result(); }

bool MissionWatch::ended() const {
  if (!mission_) return false;
  return mission_->newest().phase == msg::MissionPhase::done || last_safety_.stamp - calm_ > kSafeForGood;
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

}  // namespace sinew::app
