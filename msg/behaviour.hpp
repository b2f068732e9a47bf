#pragma once
// What a robot's behaviour does now, and why (docs/behaviour.md).
#include <string_view>

#include "msg/describe.hpp"

namespace sinew::msg {

inline constexpr std::size_t kMaxBehaviourDepth = 8, kMaxBehaviourParameters = 4, kMaxDecisionReads = 24;
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
  BehaviourName decision{};  // that led into the state; empty: the option began there, or was forced
};

/// A value that a decision read in this step.
struct DecisionRead {
  double value = 0;
  std::uint32_t depth = 0;     // of the option: its place in BehaviourState::active
  std::uint32_t reserved = 0;  // 0
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

template <>
struct Description<ActiveOption> {
  using M = ActiveOption;
  static constexpr std::string_view name = "ActiveOption", doc = "An option of a behaviour that is active.";
  static constexpr auto fields = describe(
      field<&M::entered>("ns", "when the option began"), field<&M::state_entered>("ns"),
      field<&M::parameter>("", "as the option declares them"), field<&M::option>("ascii", "its name"),
      field<&M::state>("ascii", "its name"), field<&M::decision>("ascii", "that led into the state; empty: none"));
};

template <>
struct Description<DecisionRead> {
  using M = DecisionRead;
  static constexpr std::string_view name = "DecisionRead", doc = "A value that a decision of a behaviour read.";
  static constexpr auto fields =
      describe(field<&M::value>("", "as the behaviour says"), field<&M::depth>("1", "of the option"),
               field<&M::reserved>("1", "0"), field<&M::name>("ascii"));
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

}  // namespace sinew::msg
