#pragma once
// What a robot's behaviour does now, and why (docs/behaviour.md).
#include <string_view>

#include "msg/describe.hpp"

namespace sinew::msg {

inline constexpr std::size_t kMaxBehaviourDepth = 8, kMaxBehaviourParameters = 4, kMaxDecisionReads = 24;
inline constexpr std::size_t kMaxPlanOptions = 16, kMaxPlanStates = 64, kMaxPlanDecisions = 128;
inline constexpr std::uint32_t kNoPlace = 0xFFFFFFFF;
using BehaviourName = std::array<std::uint8_t, 24>;  // ASCII, filled up with zeros

/// RT: yes.
inline std::string_view text(const BehaviourName& name) {
  std::size_t n = 0;
  while (n < name.size() && name[n]) ++n;
  return {reinterpret_cast<const char*>(name.data()), n};
}

struct ActiveOption {
  Time entered;        // when the option began
  Time state_entered;  // when it came into its state
  std::array<double, kMaxBehaviourParameters> parameter{};
  BehaviourName option{}, state{};
  BehaviourName decision{};                 // that led into the state; empty: the option began there, or was forced
  std::uint32_t decision_place = kNoPlace;  // of it in BehaviourPlan::decision
  std::uint32_t reserved = 0;               // 0
};

/// A value that a decision read in this step.
struct DecisionRead {
  double value = 0;
  std::uint32_t depth = 0;     // of the option: its place in BehaviourState::active
  std::uint32_t decision = 0;  // that read it: its place in BehaviourPlan::decision
  BehaviourName name{};
};

struct BehaviourState {
  Time stamp;
  std::uint32_t depth = 0;          // options in use, the root first
  std::uint32_t reads = 0;          // in use, in the order in which they were read
  std::uint32_t reads_dropped = 0;  // for lack of room, in this step
  std::uint32_t forced = 0;         // bit n: option n of `active` is held in its state from outside
  std::uint32_t changes = 0;        // decisions taken since the start
  std::uint32_t done = 0;           // bit n: option n of `active` is in a final state
  std::array<ActiveOption, kMaxBehaviourDepth> active{};
  std::array<DecisionRead, kMaxDecisionReads> read{};
};

struct PlanParameter {
  BehaviourName name{};  // empty: the option has fewer
};

struct PlanOption {
  BehaviourName name{};
  std::array<PlanParameter, kMaxBehaviourParameters> parameter{};
};

struct PlanState {
  BehaviourName name{};
  std::uint32_t option = 0;        // that it belongs to: its place in BehaviourPlan::option
  std::uint32_t calls = kNoPlace;  // the option that runs below it: its place
  std::uint32_t is_final = 0;      // 1: yes
  std::uint32_t reserved = 0;      // 0
};

struct PlanDecision {
  BehaviourName name{};
  std::uint32_t option = 0;       // place in BehaviourPlan::option
  std::uint32_t from = kNoPlace;  // place in BehaviourPlan::state; kNoPlace: every state of the option but `to`
  std::uint32_t to = 0;           // place in BehaviourPlan::state
  std::uint32_t reserved = 0;     // 0
};

/// The number by which a state is held is its place in `state` plus 1. The first state of an option is where it begins.
struct BehaviourPlan {
  Time stamp;
  std::uint32_t options = 0, states = 0, decisions = 0;  // in use
  std::uint32_t reserved = 0;                            // 0
  BehaviourName force{};  // parameter of the module by which a state is held; empty: none can be
  std::array<PlanOption, kMaxPlanOptions> option{};
  std::array<PlanState, kMaxPlanStates> state{};
  std::array<PlanDecision, kMaxPlanDecisions> decision{};
};

template <>
struct Description<ActiveOption> {
  using M = ActiveOption;
  static constexpr std::string_view name = "ActiveOption", doc = "An option of a behaviour that is active.";
  static constexpr auto fields = describe(
      field<&M::entered>("ns", "when the option began"), field<&M::state_entered>("ns"),
      field<&M::parameter>("", "as the option declares them"), field<&M::option>("ascii", "its name"),
      field<&M::state>("ascii", "its name"), field<&M::decision>("ascii", "that led into the state; empty: none"),
      field<&M::decision_place>("1", "of it in BehaviourPlan; 4294967295: none"), field<&M::reserved>("1", "0"));
};

template <>
struct Description<DecisionRead> {
  using M = DecisionRead;
  static constexpr std::string_view name = "DecisionRead", doc = "A value that a decision of a behaviour read.";
  static constexpr auto fields =
      describe(field<&M::value>("", "as the behaviour says"), field<&M::depth>("1", "of the option"),
               field<&M::decision>("1", "that read it: its place in BehaviourPlan"), field<&M::name>("ascii"));
};

template <>
struct Description<BehaviourState> {
  using M = BehaviourState;
  static constexpr std::string_view name = "BehaviourState", doc = "What a robot's behaviour does now, and why.";
  static constexpr auto fields =
      describe(field<&M::stamp>("ns"), field<&M::depth>("1", "active options, the root first"),
               field<&M::reads>("1", "in use"), field<&M::reads_dropped>("1", "for lack of room, in this step"),
               field<&M::forced>("1", "bit n: option n is held from outside"),
               field<&M::changes>("1", "decisions taken since the start"),
               field<&M::done>("1", "bit n: option n is in a final state"), field<&M::active>(""), field<&M::read>(""));
};

template <>
struct Description<PlanParameter> {
  using M = PlanParameter;
  static constexpr std::string_view name = "PlanParameter", doc = "A parameter of an option of a behaviour.";
  static constexpr auto fields = describe(field<&M::name>("ascii", "empty: the option has fewer"));
};

template <>
struct Description<PlanOption> {
  using M = PlanOption;
  static constexpr std::string_view name = "PlanOption", doc = "An option of a behaviour.";
  static constexpr auto fields = describe(field<&M::name>("ascii"), field<&M::parameter>(""));
};

template <>
struct Description<PlanState> {
  using M = PlanState;
  static constexpr std::string_view name = "PlanState", doc = "A state of an option of a behaviour.";
  static constexpr auto fields =
      describe(field<&M::name>("ascii"), field<&M::option>("1", "its place"),
               field<&M::calls>("1", "the option that runs below: its place; 4294967295: none"),
               field<&M::is_final>("1", "1: yes"), field<&M::reserved>("1", "0"));
};

template <>
struct Description<PlanDecision> {
  using M = PlanDecision;
  static constexpr std::string_view name = "PlanDecision", doc = "What leads from state to state.";
  static constexpr auto fields =
      describe(field<&M::name>("ascii"), field<&M::option>("1", "its place"),
               field<&M::from>("1", "place of the state; 4294967295: every state of the option but `to`"),
               field<&M::to>("1", "place of the state"), field<&M::reserved>("1", "0"));
};

template <>
struct Description<BehaviourPlan> {
  using M = BehaviourPlan;
  static constexpr std::string_view name = "BehaviourPlan",
                                    doc =
                                        "All options of a behaviour, their states, and what leads from one to another.";
  static constexpr auto fields =
      describe(field<&M::stamp>("ns"), field<&M::options>("1", "in use, the root first"),
               field<&M::states>("1", "in use"), field<&M::decisions>("1", "in use"), field<&M::reserved>("1", "0"),
               field<&M::force>("ascii", "parameter of the module that holds a state: its place plus 1; empty: none"),
               field<&M::option>(""), field<&M::state>("", "those of an option in a row; it begins in the first"),
               field<&M::decision>("", "those of an option in a row, in the order in which they are asked"));
};

}  // namespace sinew::msg
