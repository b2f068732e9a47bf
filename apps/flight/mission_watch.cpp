#include "apps/flight/mission_watch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <utility>

#include "apps/robot_file/world_report.hpp"
#include "rt/safety_text.hpp"

namespace sinew::app {
namespace {

using namespace std::chrono_literals;

constexpr const char* kGuardianState = "guardian.state";
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

std::string state_topic(const rt::ActuatorSpec& actuator) { return "guardian." + actuator.name; }

/// The estimate's topic; empty where there is no truth to hold it against.
std::string estimate_topic(const rt::Graph& graph) {
  const std::uint32_t truth = graph.find_topic(kGroundTruth);
  const bool there = truth != rt::kNone && graph.topics()[truth].type == &msg::type_info<msg::NavState>();
  return there ? first_of<msg::NavState>(graph) : std::string();
}

Story::Weight weight_of(msg::MissionPhase phase) {
  using P = msg::MissionPhase;
  if (phase == P::wait || phase == P::arm) return Story::Weight::detail;
  return phase == P::done || phase == P::abort ? Story::Weight::result : Story::Weight::phase;
}

const char* action_text(msg::FailsafeAction action) { return action == msg::FailsafeAction::stop ? "stop" : "land"; }

const char* safe_text(rt::ActuatorSpec::Safe safe) {
  using S = rt::ActuatorSpec::Safe;
  switch (safe) {
    case S::stop:
      return "stop";
    case S::hold:
      return "hold";
    case S::damp:
      return "damp";
    case S::torque_off:
      return "torque off";
  }
  return "?";
}

/// Why a group went to its safe action, of the first fault that says so.
std::string fault_text(std::uint32_t faults, const rt::ActuatorSpec& a) {
  if (faults & msg::kFaultDevice) return "the device refuses commands";
  if (faults & msg::kFaultCount) return "commands on " + a.command.value + " with a wrong number of channels";
  if (faults & msg::kFaultNotFinite) return "commands on " + a.command.value + " are not finite";
  if (faults & msg::kFaultLimit) return "commands on " + a.command.value + " beyond the limit";
  if (faults & msg::kFaultLease)
    return fmt::format("no valid command on {} for {:g} ms", a.command.value, 1e3 * msg::seconds(a.lease));
  return "commands do not pass";
}

}  // namespace

std::vector<std::string> MissionWatch::taps(const rt::Graph& graph) {
  std::vector<std::string> names;
  const auto add = [&](const std::string& name) {
    if (graph.find_topic(name) != rt::kNone) names.push_back(name);
  };
  add(first_of<msg::MissionState>(graph));
  add(kGuardianState);
  for (const rt::ActuatorSpec& a : graph.spec().actuators) add(state_topic(a));
  if (const std::string estimate = estimate_topic(graph); !estimate.empty()) {
    names.push_back(estimate);
    names.emplace_back(kGroundTruth);
  }
  return names;
}

MissionWatch::MissionWatch(rt::Graph& graph) : spec_(&graph.spec()) {
  if (graph.taps().empty()) return;
  latch_.emplace(graph.segment());
  const std::vector<std::string> names = taps(graph);
  const std::string mission = first_of<msg::MissionState>(graph);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const rt::ConnectionId tap = graph.taps()[i];
    const auto follow = [&](auto& followed) { followed.emplace(*latch_, graph.segment(), tap); };
    const auto group =
        std::ranges::find_if(spec_->actuators, [&](const auto& a) { return state_topic(a) == names[i]; });
    if (names[i] == kGuardianState)
      follow(safety_);
    else if (names[i] == mission)
      follow(mission_);
    else if (group != spec_->actuators.end())
      groups_.push_back(std::make_unique<Group>(*latch_, graph.segment(), tap, *group));
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
  if (mission_) mission_->each([this](const msg::MissionState& state) { see(state); });
  if (safety_) safety_->each([this](const msg::SafetyState& state) { see(state); });
  for (const auto& group : groups_)
    group->state.each([&](const msg::GuardianState& state) { see(*group, state, events_); });
  if (estimate_ && truth_ && estimate_->any() && truth_->any()) error_.add(estimate_->newest(), truth_->newest());
  return mission_ && mission_->any() ? &mission_->newest() : nullptr;
}

void MissionWatch::see(const msg::MissionState& state) {
  if (phase_ == state.phase) return;
  phase_ = state.phase;
  events_.push_back({state.phase_since, weight_of(state.phase), to_string(state.phase)});
}

void MissionWatch::see(const msg::SafetyState& state) {
  const msg::SafetyState before = std::exchange(last_safety_, state);
  const bool over = state.mode == msg::GuardianMode::safe && state.groups_moving == 0;
  if (!over || calm_.ns == 0) calm_ = state.stamp;
  const auto add = [&](rt::Time at, Story::Weight weight, std::string text) {
    events_.push_back({at, weight, std::move(text)});
  };
  for (std::size_t i = 0; i < spec_->failsafes.size(); ++i) {
    const rt::FailsafeSpec& f = spec_->failsafes[i];
    // What latched and was disarmed between two messages still shows as acted.
    const std::uint32_t acts = (state.latched & ~before.latched) | (state.acted & ~before.acted);
    if (acts >> i & 1)
      add(state.stamp, Story::Weight::result,
          fmt::format("{}: {} -> {}", f.name, rt::cause_text(f, state.measured[i]), action_text(f.action)));
  }
  const bool none_new = (state.latched & ~before.latched) == 0;
  if (none_new && before.action == msg::FailsafeAction::land && state.action == msg::FailsafeAction::stop)
    add(state.stamp, Story::Weight::result, "the landing took too long -> stop");
  if (state.disarmed > before.disarmed)
    add(state.disarmed, Story::Weight::result, "disarmed, while the actuators were live");
  else if (spec_->guardian.arming == rt::GuardianSpec::Arming::manual && state.permitted != before.permitted)
    add(state.stamp, Story::Weight::phase, state.permitted ? "armed" : "not armed any more");
}

void MissionWatch::see(Group& group, const msg::GuardianState& state, std::vector<Event>& events) {
  const rt::ActuatorSpec& spec = group.spec;
  const msg::GuardianMode before = std::exchange(group.mode, state.mode);
  if (state.mode == msg::GuardianMode::active) {
    const std::size_t n = std::min<std::size_t>(state.count, state.value.size());
    const auto values = std::span(state.value).first(n);
    const auto low = [&](double v) { return v <= spec.min; };
    const auto at_limit = [&](double v) { return low(v) || v >= spec.max; };
    ++group.live;
    group.at_limit += std::ranges::any_of(values, at_limit) && !std::ranges::all_of(values, low);  // all low: idle
  }
  const bool was_live = before == msg::GuardianMode::active || before == msg::GuardianMode::armed;
  // Of a failsafe the guardian's own state tells.
  if (state.mode == msg::GuardianMode::safe && was_live && !(state.faults & msg::kFaultFailsafe))
    events.push_back({state.stamp, Story::Weight::result,
                      fmt::format("{}: {} -> {}", spec.name, fault_text(state.faults, spec), safe_text(spec.safe))});
  if (state.mode == msg::GuardianMode::active && before == msg::GuardianMode::safe)
    events.push_back({state.stamp, Story::Weight::phase, spec.name + ": commands pass again"});
}

std::vector<MissionWatch::Event> MissionWatch::take_events() { return std::exchange(events_, {}); }

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
