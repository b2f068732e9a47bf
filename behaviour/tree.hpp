#pragma once
// A behaviour: options with states, what leads from state to state, and what is done there. Board is any struct of the
// user: what decisions read and actions write.
//
//   struct Board { double ball_m = 9, walk_mps = 0; };
//   behaviour::Tree<Board> tree;
//   auto& play = tree.option("play");
//   play.state("go").act([](Board& b, const behaviour::Here&) { b.walk_mps = 0.2; })
//       .to("stand", "near", [](const Board& b, behaviour::Look& look) { return look("ball_m", b.ball_m) < 0.2; });
//   play.state("stand").act([](Board& b, const behaviour::Here&) { b.walk_mps = 0; }).is_final();
//   const auto problems = tree.resolve();  // in configure()
//   tree.step(progress, board, now, {}, state);  // in step(): `progress` is the module's state, `state` its message
//
// Source:  the notions are those of XABSL (Loetzsch, Risler, Juengel: XABSL - a pragmatic approach to behavior
//          engineering, IROS 2006); docs/behaviour.md says what differs.
#include <chrono>
#include <deque>
#include <initializer_list>
#include <span>

#include "behaviour/plan.hpp"

namespace sinew::behaviour {

using msg::Time;
using Parameters = std::array<double, msg::kMaxBehaviourParameters>;

inline constexpr std::chrono::seconds kPlanPeriod{5};

/// Where a tree is: all that it keeps between steps. One may be a module's state (rt::Declaration::state()).
struct Progress {
  struct Level {
    std::int64_t entered_ns = 0, state_entered_ns = 0;
    std::uint32_t option = 0, state = 0;
    /// That led into the state, kNone: none did. common 1: its place in `always`. 0: its place in the state that it
    /// left, and in the upper 16 bits that state.
    std::uint32_t decision = kNone, common = 0;
  };
  std::array<Level, msg::kMaxBehaviourDepth> level{};
  std::uint32_t depth = 0, changes = 0;
  std::int64_t next_plan_ns = 0;

  /// True at the first step and each kPlanPeriod after it: when a module publishes its plan, so that each part of a
  /// recording has it.   RT: yes.
  bool tells_plan(Time now);
};

/// What an action knows besides the board.
struct Here {
  double in_option_s, in_state_s;
  const Parameters& parameter;
};

/// What a decision knows besides the board. Values that go through operator() are in the message.
class Look {
 public:
  Look(const Here& here, bool done, std::uint32_t depth, msg::BehaviourState& into)
      : here_(here), done_(done), depth_(depth), into_(into) {}

  double operator()(std::string_view name, double value);
  bool operator()(std::string_view name, bool value) { return (*this)(name, value ? 1.0 : 0.0) != 0; }
  double parameter(std::size_t i) const { return here_.parameter[i]; }
  double in_option_s() { return (*this)("in_option_s", here_.in_option_s); }
  double in_state_s() { return (*this)("in_state_s", here_.in_state_s); }
  /// The option below this state was in a final state at the end of the step before.
  bool done() { return (*this)("done", done_); }
  /// Of the runner: the decision that is asked next, by its place in the plan.
  void asks(std::uint32_t decision) { decision_ = decision; }

 private:
  const Here& here_;
  bool done_;
  std::uint32_t depth_, decision_ = kNone;
  msg::BehaviourState& into_;
};

/// What has no template parameter: the rules of a step (docs/behaviour.md#a-step).
class Runner {
 public:
  /// The functions of the user. `which`: decision of the state, or of the option when `common`.
  class Calls {
   public:
    virtual bool decide(const Progress::Level& at, bool common, std::uint32_t which, Look& look) = 0;
    virtual void act(const Progress::Level& at, const Here& here) = 0;
    virtual void arguments(const Progress::Level& caller, const Here& here, Parameters& out) = 0;

   protected:
    ~Calls() = default;
  };
  /// RT: yes. `plan` was resolved without a problem.
  static void step(const Plan& plan, Calls& calls, Progress& progress, Time now, Plan::Place force,
                   msg::BehaviourState& out);
};

/// Thread:  owner.   RT: step() only.   Errors:  a tree that was not resolved without problems does nothing in step().
template <class Board>
class Tree {
 public:
  using Decide = bool (*)(const Board&, Look&);
  using Act = void (*)(Board&, const Here&);
  using Arguments = void (*)(const Board&, const Here&, Parameters&);

  class State {
   public:
    State& act(Act what) {
      act_ = what;
      return *this;
    }
    /// The first decision that says yes is taken, in the order in which they were added.
    State& to(std::string_view target, std::string_view name, Decide decide) {
      plan_.decisions.push_back({std::string(name), std::string(target)});
      decide_.push_back(decide);
      return *this;
    }
    /// Runs this option below, with these arguments.
    State& calls(std::string_view option, Arguments arguments = nullptr) {
      plan_.callee = option;
      arguments_ = arguments;
      return *this;
    }
    State& is_final() {
      plan_.is_final = true;
      return *this;
    }

   private:
    friend class Tree;
    Plan::State plan_;
    std::vector<Decide> decide_;
    Act act_ = nullptr;
    Arguments arguments_ = nullptr;
  };

  class Option {
   public:
    State& state(std::string_view name) {
      states_.emplace_back().plan_.name = name;
      return states_.back();
    }
    /// From every state of this option but the target.
    Option& always(std::string_view target, std::string_view name, Decide decide) {
      plan_.always.push_back({std::string(name), std::string(target)});
      decide_.push_back(decide);
      return *this;
    }

   private:
    friend class Tree;
    Plan::Option plan_;
    std::vector<Decide> decide_;
    std::deque<State> states_;
  };

  /// References to options and states stay valid. The first option is the root.
  Option& option(std::string_view name, std::initializer_list<std::string_view> parameters = {}) {
    Option& added = options_.emplace_back();
    added.plan_.name = name;
    added.plan_.parameters.assign(parameters.begin(), parameters.end());
    return added;
  }

  /// See Plan::resolve(). After it nothing is added any more.
  std::vector<std::string> resolve() {
    plan_.options.clear();
    for (const Option& option : options_) {
      plan_.options.push_back(option.plan_);
      for (const State& state : option.states_) plan_.options.back().states.push_back(state.plan_);
    }
    std::vector<std::string> problems = plan_.resolve();
    ready_ = problems.empty();
    return problems;
  }
  const Plan& plan() const { return plan_; }

  /// `force`: an option that is active, or becomes so, is held in this state.
  void step(Progress& progress, Board& board, Time now, Plan::Place force, msg::BehaviourState& out) const {
    if (!ready_) return;
    Bound bound{*this, board};
    Runner::step(plan_, bound, progress, now, force, out);
  }

 private:
  struct Bound final : Runner::Calls {
    Bound(const Tree& t, Board& b) : tree(t), board(b) {}
    const State& at(const Progress::Level& l) const { return tree.options_[l.option].states_[l.state]; }
    bool decide(const Progress::Level& l, bool common, std::uint32_t which, Look& look) override {
      return common ? tree.options_[l.option].decide_[which](board, look) : at(l).decide_[which](board, look);
    }
    void act(const Progress::Level& l, const Here& here) override {
      if (at(l).act_) at(l).act_(board, here);
    }
    void arguments(const Progress::Level& l, const Here& here, Parameters& out) override {
      if (at(l).arguments_) at(l).arguments_(board, here, out);
    }
    const Tree& tree;
    Board& board;
  };

  std::deque<Option> options_;
  Plan plan_;
  bool ready_ = false;
};

}  // namespace sinew::behaviour
