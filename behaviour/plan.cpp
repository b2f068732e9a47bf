#include "behaviour/plan.hpp"

#include <algorithm>
#include <set>

#include "rt/module.hpp"

namespace sinew::behaviour {
namespace {

template <class Named>
std::uint32_t place_of(const std::vector<Named>& all, std::string_view name) {
  for (std::uint32_t i = 0; i < all.size(); ++i)
    if (all[i].name == name) return i;
  return kNone;
}

bool allowed(std::string_view name) {
  const auto fits = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; };
  return !name.empty() && name.size() < msg::BehaviourName{}.size() && std::all_of(name.begin(), name.end(), fits);
}

std::string in_quotes(std::string_view name) { return "'" + std::string(name) + "'"; }

class Checker {
 public:
  explicit Checker(Plan& plan) : plan_(plan) {}

  std::vector<std::string> run() {
    if (plan_.options.empty()) say("the plan has no option");
    for (std::uint32_t o = 0; o < plan_.options.size(); ++o) check_names(o);
    for (Plan::Option& option : plan_.options) check_states(option);
    check_calls();
    number();
    return std::move(problems_);
  }

 private:
  void say(std::string text) { problems_.push_back(std::move(text)); }
  static std::string of(const Plan::Option& option) { return "option " + in_quotes(option.name) + ": "; }

  void check_name(std::string_view name, const std::string& where) {
    if (!allowed(name)) say(where + in_quotes(name) + " is no name: 1 to 23 of a-z, 0-9 and _");
  }
  void look_up(const Plan::Option& option, Plan::Decision& decision, const std::string& where) {
    check_name(decision.name, where);
    decision.to = place_of(option.states, decision.target);
    if (decision.to == kNone)
      say(where + "decision " + in_quotes(decision.name) + " leads to " + in_quotes(decision.target) +
          ", which is no state of this option");
  }

  void check_names(std::uint32_t o) {
    Plan::Option& option = plan_.options[o];
    check_name(option.name, "option ");
    if (place_of(plan_.options, option.name) != o) say("two options have the name " + in_quotes(option.name));
    if (option.states.empty()) say(of(option) + "it has no state");
    if (option.parameters.size() > msg::kMaxBehaviourParameters)
      say(of(option) + "it has more than " + std::to_string(msg::kMaxBehaviourParameters) + " parameters");
    for (Plan::Decision& decision : option.always) look_up(option, decision, of(option));
    for (std::uint32_t s = 0; s < option.states.size(); ++s) {
      Plan::State& state = option.states[s];
      check_name(state.name, of(option) + "state ");
      if (place_of(option.states, state.name) != s)
        say(of(option) + "two states have the name " + in_quotes(state.name));
      const std::string where = of(option) + "state " + in_quotes(state.name) + ": ";
      for (Plan::Decision& decision : state.decisions) look_up(option, decision, where);
      state.calls = state.callee.empty() ? kNone : place_of(plan_.options, state.callee);
      if (!state.callee.empty() && state.calls == kNone)
        say(where + "it calls " + in_quotes(state.callee) + ", which is no option");
    }
  }

  void check_states(const Plan::Option& option) {
    if (option.states.empty()) return;
    std::vector<bool> reached(option.states.size(), false);
    std::vector<std::uint32_t> open{0};
    for (const Plan::Decision& decision : option.always)
      if (decision.to != kNone) open.push_back(decision.to);
    while (!open.empty()) {
      const std::uint32_t s = open.back();
      open.pop_back();
      if (reached[s]) continue;
      reached[s] = true;
      for (const Plan::Decision& decision : option.states[s].decisions)
        if (decision.to != kNone) open.push_back(decision.to);
    }
    for (std::uint32_t s = 0; s < option.states.size(); ++s) {
      const Plan::State& state = option.states[s];
      const std::string where = of(option) + "state " + in_quotes(state.name) + ": ";
      if (!reached[s]) say(where + "no decision leads to it");
      const auto leaves = [s](const Plan::Decision& decision) { return decision.to != s; };
      const bool own = std::any_of(state.decisions.begin(), state.decisions.end(), leaves);
      const bool common = std::any_of(option.always.begin(), option.always.end(), leaves);
      if (!state.is_final && !own && !common) say(where + "no decision leads out of it, and it is not final");
      if (state.is_final && own) say(where + "it is final, but a decision leads out of it");
    }
  }

  void check_calls() {
    if (plan_.options.empty()) return;
    called_.insert(0);
    visit(0);
    for (std::uint32_t o = 0; o < plan_.options.size(); ++o)
      if (!called_.contains(o)) say(of(plan_.options[o]) + "no state that can be active calls it");
  }
  void visit(std::uint32_t o) {
    if (std::find(path_.begin(), path_.end(), o) != path_.end()) {
      say(of(plan_.options[o]) + "it calls itself, by itself or by others");
      return;
    }
    if (path_.size() == msg::kMaxBehaviourDepth) {
      say(of(plan_.options[o]) + "it is called deeper than " + std::to_string(msg::kMaxBehaviourDepth) + " options");
      return;
    }
    path_.push_back(o);
    std::set<std::uint32_t> below;
    for (const Plan::State& state : plan_.options[o].states)
      if (state.calls != kNone) below.insert(state.calls);
    for (const std::uint32_t callee : below) {
      called_.insert(callee);
      visit(callee);
    }
    path_.pop_back();
  }

  /// Gives each decision its place, and looks whether all have room in the message.
  void number() {
    std::uint32_t states = 0, decisions = 0;
    for (Plan::Option& option : plan_.options) {
      states += static_cast<std::uint32_t>(option.states.size());
      for (Plan::Decision& decision : option.always) decision.place = decisions++;
      for (Plan::State& state : option.states)
        for (Plan::Decision& decision : state.decisions) decision.place = decisions++;
    }
    const auto at_most = [this](std::size_t n, std::size_t most, const char* what) {
      if (n > most) say("the plan has " + std::to_string(n) + " " + what + ", at most " + std::to_string(most));
    };
    at_most(plan_.options.size(), msg::kMaxPlanOptions, "options");
    at_most(states, msg::kMaxPlanStates, "states");
    at_most(decisions, msg::kMaxPlanDecisions, "decisions");
  }

  Plan& plan_;
  std::vector<std::string> problems_;
  std::set<std::uint32_t> called_;
  std::vector<std::uint32_t> path_;
};

}  // namespace

std::vector<std::string> Plan::resolve() { return Checker(*this).run(); }

Plan::Place Plan::find(std::string_view option_and_state) const {
  const auto slash = option_and_state.find('/');
  if (slash == std::string_view::npos) return {};
  const std::uint32_t option = place_of(options, option_and_state.substr(0, slash));
  if (option == kNone) return {};
  const std::uint32_t state = place_of(options[option].states, option_and_state.substr(slash + 1));
  return state == kNone ? Place{} : Place{option, state};
}

Plan::Place Plan::numbered(std::int64_t number) const {
  std::int64_t before = 0;
  for (std::uint32_t o = 0; o < options.size(); ++o) {
    const auto states = static_cast<std::int64_t>(options[o].states.size());
    if (number > before && number <= before + states) return {o, static_cast<std::uint32_t>(number - before - 1)};
    before += states;
  }
  return {};
}

void Plan::describe(std::string_view force, msg::BehaviourPlan& out) const {
  out = {};
  put(force, out.force);
  for (const Option& option : options) {
    const std::uint32_t o = out.options++, first = out.states;
    put(option.name, out.option[o].name);
    for (std::size_t p = 0; p < option.parameters.size(); ++p)
      put(option.parameters[p], out.option[o].parameter[p].name);
    const auto add = [&](const Decision& decision, std::uint32_t from) {
      msg::PlanDecision& added = out.decision[out.decisions++];
      put(decision.name, added.name);
      added.option = o;
      added.from = from;
      added.to = first + decision.to;
    };
    for (const Decision& decision : option.always) add(decision, msg::kNoPlace);
    for (const State& state : option.states) {
      msg::PlanState& added = out.state[out.states];
      put(state.name, added.name);
      added.option = o;
      added.calls = state.calls;
      added.is_final = state.is_final ? 1 : 0;
      for (const Decision& decision : state.decisions) add(decision, out.states);
      ++out.states;
    }
  }
}

std::string Plan::graphviz() const {
  std::int64_t number = 0;
  std::string text = "digraph behaviour {\n  compound=true;\n  node [shape=box, style=rounded];\n";
  const auto node = [](const Option& option, std::string_view state) {
    return "\"" + option.name + "/" + std::string(state) + "\"";
  };
  for (const Option& option : options) {
    text += "  subgraph \"cluster_" + option.name + "\" {\n    label=\"" + option.name + "\";\n";
    for (const State& state : option.states)
      text += "    " + node(option, state.name) + " [label=\"" + std::to_string(++number) + " " + state.name + "\"" +
              (state.is_final ? ", peripheries=2" : "") + "];\n";
    for (const Decision& decision : option.always)
      for (const State& state : option.states)
        if (state.name != decision.target)
          text += "    " + node(option, state.name) + " -> " + node(option, decision.target) + " [label=\"" +
                  decision.name + "\", color=gray];\n";
    for (const State& state : option.states)
      for (const Decision& decision : state.decisions)
        text += "    " + node(option, state.name) + " -> " + node(option, decision.target) + " [label=\"" +
                decision.name + "\"];\n";
    text += "  }\n";
  }
  for (const Option& option : options)
    for (const State& state : option.states)
      if (state.calls != kNone && !options[state.calls].states.empty())
        text += "  " + node(option, state.name) + " -> " +
                node(options[state.calls], options[state.calls].states[0].name) + " [style=dashed, lhead=\"cluster_" +
                options[state.calls].name + "\"];\n";
  return text + "}\n";
}

std::string Plan::mermaid() const {
  std::string text = "stateDiagram-v2\n";
  std::int64_t number = 0;
  for (const Option& option : options) {
    const std::string prefix = option.name + "__";
    text += "  state " + option.name + " {\n";
    if (!option.states.empty()) text += "    [*] --> " + prefix + option.states[0].name + "\n";
    for (const State& state : option.states) {
      text += "    " + prefix + state.name + " : " + std::to_string(++number) + " " + state.name +
              (state.callee.empty() ? "" : " (runs " + state.callee + ")") + "\n";
      if (state.is_final) text += "    " + prefix + state.name + " --> [*]\n";
      const auto arrow = [&](const Decision& decision) {
        if (state.name != decision.target)
          text += "    " + prefix + state.name + " --> " + prefix + decision.target + " : " + decision.name + "\n";
      };
      for (const Decision& decision : option.always) arrow(decision);
      for (const Decision& decision : state.decisions) arrow(decision);
    }
    text += "  }\n";
  }
  return text;
}

void put(std::string_view name, msg::BehaviourName& out) {
  out.fill(0);
  for (std::size_t i = 0; i < name.size() && i + 1 < out.size(); ++i) out[i] = static_cast<std::uint8_t>(name[i]);
}

bool explain(const std::vector<std::string>& problems, rt::Setup& setup) {
  for (const std::string& problem : problems) setup.explain("behaviour: " + problem);
  return problems.empty();
}

}  // namespace sinew::behaviour
