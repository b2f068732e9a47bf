#pragma once
// The names of a behaviour and how they hang together, without what it decides and does: checked and drawn.
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "msg/behaviour.hpp"

namespace sinew::rt {
class Setup;
}

namespace sinew::behaviour {

inline constexpr std::uint32_t kNone = msg::kNoPlace;

/// Names are [a-z0-9_]+, at most 23 bytes. The first option of a plan is its root, the first state of an option is the
/// one in which it begins.
/// Thread:  owner, configure only; reading: any.
struct Plan {
  struct Decision {
    std::string name, target;
    std::uint32_t to = kNone;     // place of the target in the option's states; set by resolve()
    std::uint32_t place = kNone;  // among all decisions of the plan, as in msg::BehaviourPlan; set by resolve()
  };
  struct State {
    std::string name, callee;  // callee: the option that runs below this state; empty: none
    bool is_final = false;
    std::vector<Decision> decisions;
    std::uint32_t calls = kNone;  // place of the callee in `options`; set by resolve()
  };
  struct Option {
    std::string name;
    std::vector<std::string> parameters;
    std::vector<Decision> always;  // looked at before those of the state
    std::vector<State> states;
  };
  std::vector<Option> options;

  /// Looks every name up and checks the whole. Empty: the plan can run. Each problem is a sentence that names the
  /// option and the state: a name that is missing, double or not allowed; a state that nothing leads to; a state
  /// without a way out that is not final, or a final one with a way out; an option that nothing calls; options that
  /// call each other in a circle, or deeper than msg::kMaxBehaviourDepth; more than msg::BehaviourPlan has room for.
  std::vector<std::string> resolve();
  /// "option/state". `option` is kNone when there is no such option or state.
  struct Place {
    std::uint32_t option = kNone, state = kNone;
  };
  /// RT: yes.
  Place find(std::string_view option_and_state) const;
  /// The state with this number: 1 is the first state of the first option, and so on through the plan. Drawings show
  /// the numbers, so that a module's parameter, which is a number while the robot runs, can hold a state. None: others.
  /// RT: yes.
  Place numbered(std::int64_t number) const;
  /// All of it, for those who look at the robot. `force`: the module's parameter that numbered() is given; empty: none.
  /// `out.stamp` is left to the caller.
  void describe(std::string_view force, msg::BehaviourPlan& out) const;
  /// The plan as text of Graphviz's dot, and of Mermaid's stateDiagram-v2.
  std::string graphviz() const;
  std::string mermaid() const;
};

/// RT: yes.
void put(std::string_view name, msg::BehaviourName& out);

/// What a module says in configure() of the problems of its plan. False: there were some.
bool explain(const std::vector<std::string>& problems, rt::Setup& setup);

}  // namespace sinew::behaviour
