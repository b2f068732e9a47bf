#include "record/run/ring_trigger.hpp"

namespace sinew::record {

RingTrigger::RingTrigger(const rt::Graph& graph) : graph_(graph), missed_(graph.threads().size()) {
  for (const rt::GraphThread& t : graph.threads()) period_.push_back(t.spec.period);
  for (std::uint32_t t = 0; t < graph.topics().size(); ++t)
    if (graph.topics()[t].type == &msg::type_info<msg::SafetyState>()) safety_ = t;
}

/// Overruns as the executors count them: the cycle is not over at its next release.
std::optional<std::string> RingTrigger::step(const LoggedStep& s) {
  const std::string& module = graph_.modules()[s.module].spec.name;
  if (s.status == rt::StepStatus::fault) return "fault of " + module;
  const rt::Duration period = period_[s.thread];
  if (period.count() == 0 || s.completed - s.release <= period || s.release == missed_[s.thread]) return std::nullopt;
  missed_[s.thread] = s.release;
  return "deadline miss of " + graph_.threads()[s.thread].spec.name;
}

void RingTrigger::request(const LoggedRequest& r) {
  const auto* ns = std::get_if<std::int64_t>(&r.request.value);
  if (r.request.kind == rt::Request::Kind::set_period && ns && !r.effect.refused)
    period_[r.request.thread] = rt::Duration{*ns};
}

std::optional<std::string> RingTrigger::safety(const msg::SafetyState& state) {
  const std::uint32_t acts = state.acted & ~acted_;
  const bool safe = state.mode == msg::GuardianMode::safe && mode_ != msg::GuardianMode::safe;
  acted_ = state.acted, mode_ = state.mode;
  for (std::size_t i = 0; i < graph_.spec().failsafes.size(); ++i)
    if ((acts >> i & 1) != 0) return "failsafe " + graph_.spec().failsafes[i].name;
  return safe ? std::optional<std::string>("guardian: safe action") : std::nullopt;
}

}  // namespace sinew::record
