#include "behaviour/tree.hpp"

namespace sinew::behaviour {
namespace {

Here here(const Progress::Level& level, Time now, const Parameters& parameter) {
  return {msg::seconds(now - Time{level.entered_ns}), msg::seconds(now - Time{level.state_entered_ns}), parameter};
}

bool is_final(const Plan& plan, const Progress::Level& level) {
  return plan.options[level.option].states[level.state].is_final;
}

void enter(Progress::Level& level, std::uint32_t state, std::uint32_t decision, bool common, Time now) {
  level.state = state;
  level.state_entered_ns = now.ns;
  level.decision = decision;
  level.common = common ? 1 : 0;
}

/// The first decision that says yes. True: the option is in another state, or in the same one anew.
bool take_decision(const Plan& plan, Runner::Calls& calls, Progress::Level& level, Time now, Look& look) {
  const Plan::Option& option = plan.options[level.option];
  for (std::uint32_t i = 0; i < option.always.size(); ++i) {
    if (option.always[i].to == level.state) continue;
    look.asks(option.always[i].place);
    if (!calls.decide(level, true, i, look)) continue;
    enter(level, option.always[i].to, i, true, now);
    return true;
  }
  const Plan::State& state = option.states[level.state];
  for (std::uint32_t i = 0; i < state.decisions.size(); ++i) {
    look.asks(state.decisions[i].place);
    if (!calls.decide(level, false, i, look)) continue;
    // The decision is found again by the state that it left; see report().
    enter(level, state.decisions[i].to, i | (level.state << 16), false, now);
    return true;
  }
  return false;
}

void report(const Plan& plan, const Progress::Level& level, const Parameters& parameter, msg::ActiveOption& out) {
  const Plan::Option& option = plan.options[level.option];
  out.entered = Time{level.entered_ns};
  out.state_entered = Time{level.state_entered_ns};
  out.parameter = parameter;
  put(option.name, out.option);
  put(option.states[level.state].name, out.state);
  if (level.decision == kNone) return;
  const Plan::Decision& by = level.common ? option.always[level.decision]
                                          : option.states[level.decision >> 16].decisions[level.decision & 0xFFFF];
  put(by.name, out.decision);
  out.decision_place = by.place;
}

}  // namespace

bool Progress::tells_plan(Time now) {
  if (now.ns < next_plan_ns) return false;
  next_plan_ns = now.ns + std::chrono::nanoseconds(kPlanPeriod).count();
  return true;
}

double Look::operator()(std::string_view name, double value) {
  if (into_.reads == into_.read.size()) {
    ++into_.reads_dropped;
    return value;
  }
  msg::DecisionRead& read = into_.read[into_.reads++];
  read.value = value;
  read.depth = depth_;
  read.decision = decision_;
  put(name, read.name);
  return value;
}

void Runner::step(const Plan& plan, Calls& calls, Progress& progress, Time now, Plan::Place force,
                  msg::BehaviourState& out) {
  out = {};
  out.stamp = now;
  Parameters parameter{};
  std::uint32_t option = 0;
  bool anew = false;  // the option above came into another state: what is below begins anew
  for (std::uint32_t d = 0; option != kNone && d < progress.level.size(); ++d) {
    Progress::Level& level = progress.level[d];
    const bool begins = anew || d >= progress.depth || level.option != option;
    if (begins) level = {now.ns, now.ns, option, 0, kNone, 0};
    bool changed = begins;
    if (force.option == option) {
      out.forced |= 1U << d;
      if (level.state != force.state) {
        enter(level, force.state, kNone, false, now);
        changed = true;
      }
    } else {
      const Progress::Level* below = !begins && d + 1 < progress.depth ? &progress.level[d + 1] : nullptr;
      const Here at = here(level, now, parameter);
      Look look(at, below && is_final(plan, *below), d, out);
      if (take_decision(plan, calls, level, now, look)) {
        ++progress.changes;
        changed = true;
      }
    }
    report(plan, level, parameter, out.active[d]);
    if (is_final(plan, level)) out.done |= 1U << d;
    out.depth = d + 1;
    const Here at = here(level, now, parameter);
    calls.act(level, at);
    Parameters arguments{};
    calls.arguments(level, at, arguments);
    option = plan.options[level.option].states[level.state].calls;
    parameter = arguments;
    anew = changed;
  }
  progress.depth = out.depth;
  out.changes = progress.changes;
}

}  // namespace sinew::behaviour
