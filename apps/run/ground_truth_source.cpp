#include "apps/run/ground_truth_source.hpp"

#include <algorithm>

#include "math/elementary.hpp"
#include "rt/graph.hpp"
#include "rt/graph_check.hpp"

namespace sinew::app {
namespace {

constexpr const char* kTruthType = "app::GroundTruth";
constexpr double kNotKnown = math::kNan;  // of the same bits on every machine
constexpr msg::Vec3 kNoVector{kNotKnown, kNotKnown, kNotKnown};

/// A state of which nothing is known but that what will be set is true.
msg::NavState unknown_state(rt::Time stamp) {
  msg::NavState state;
  state.stamp = stamp;
  state.gyro_radps = state.gyro_bias_radps = state.accel_bias_mps2 = state.pad_world_m = kNoVector;
  state.height_m = state.tilt_std_rad = state.p_std_m = state.v_std_mps = kNotKnown;
  state.attitude_valid = state.position_valid = 1;
  return state;
}

}  // namespace

void GroundTruthSource::play(std::vector<msg::NavState> states) {
  states_ = std::move(states);
  plays_.store(true, std::memory_order_release);
}

bool GroundTruthSource::publish(const msg::NavState& state) noexcept {
  msg::NavState* const to = state_.loan();
  if (to) *to = state;
  return to != nullptr;
}

void GroundTruthSource::collect(rt::Time now) noexcept {
  for (; coming_.size() > 0 && coming_.at(0).stamp <= now; coming_.pop())
    if (!publish(coming_.at(0))) return;
  if (!plays_.load(std::memory_order_acquire)) return;
  for (; next_ < states_.size() && states_[next_].stamp <= now; ++next_)
    if (!publish(states_[next_])) return;
}

msg::NavState true_state(const dataset::GroundTruthSample& sample, rt::Time stamp) {
  msg::NavState state = unknown_state(stamp);
  state.q_world_base = sample.q_world_base;
  state.v_world_mps = sample.v_world_mps;
  state.p_world_m = sample.p_world_m;
  state.gyro_bias_radps = sample.gyro_bias_radps;
  state.accel_bias_mps2 = sample.accel_bias_mps2;
  return state;
}

msg::NavState true_state(const sim_hil::Truth& truth, rt::Time stamp) {
  msg::NavState state = unknown_state(stamp);
  state.q_world_base = truth.q_world_base;
  state.v_world_mps = truth.v_world_mps;
  state.p_world_m = truth.p_world_m;
  state.gyro_radps = truth.gyro_radps;
  state.pad_world_m = truth.pad_world_m;
  state.pad_known = 1;
  state.at_rest = truth.landed;
  return state;
}

void add_ground_truth(rt::GraphSpec& robot) {
  const auto is_it = [](const auto& x) { return x.name == rt::kGroundTruth; };
  const auto has_it = [](const rt::TopicSpec& t) { return rt::is_ground_truth(t.name); };  // from outside, say
  if (std::ranges::any_of(robot.modules, is_it) || std::ranges::any_of(robot.threads, is_it) ||
      std::ranges::any_of(robot.topics, has_it))
    return;
  rt::ModuleSpec module;
  module.name = rt::kGroundTruth;
  module.type = kTruthType;
  // The shortest that there is, so that it delays no other thread of ordinary priority.
  module.exec = {rt::ExecModel::Kind::constant, rt::Duration{1}};
  rt::ThreadSpec thread;
  thread.name = rt::kGroundTruth;
  thread.period = std::chrono::milliseconds(10);
  thread.stack_kib = 64;  // it copies
  thread.order.push_back({module.name, 0});
  robot.modules.push_back(std::move(module));
  robot.threads.push_back(std::move(thread));
}

void add_ground_truth_type(rt::ModuleTypes& types) {
  if (!types.make(kTruthType)) types.add<GroundTruthSource>(kTruthType);
}

GroundTruthSource* find_ground_truth(rt::Graph& graph) {
  for (const auto& m : graph.modules())
    if (auto* source = dynamic_cast<GroundTruthSource*>(m.module.get())) return source;
  return nullptr;
}

}  // namespace sinew::app
