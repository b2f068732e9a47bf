#pragma once
// What a learned policy saw and said, beside the commands themselves.
#include "msg/geometry.hpp"

namespace sinew::msg {

inline constexpr std::size_t kMaxPolicyTopics = 12;
inline constexpr std::size_t kMaxPolicyObservation = 128, kMaxPolicyOutput = 32;

/// One topic as a policy's step found it. Counts are since the start.
struct PolicyTopic {
  std::int64_t age_ns = 0;      // of the message that went in: from its stamp to the step
  std::uint32_t arrived = 0;    // messages of the topic since the step before: 1 while both keep pace
  std::uint32_t repeated = 0;   // steps that saw the same message as the step before
  std::uint32_t skipped = 0;    // messages that no step saw
  std::uint32_t reordered = 0;  // steps whose message was stamped before that of the step before
};

/// How old a policy's observation was: the first thing to look at when it shakes on the robot and did not in training.
struct PolicyState {
  Time stamp;                                         // of the step
  std::array<PolicyTopic, kMaxPolicyTopics> topic{};  // in the order of the robot file
  std::uint32_t topics = 0;                           // in use
  std::uint32_t clipped = 0;                          // numbers of this observation at an end of their clip range
  std::uint32_t clipped_commands = 0;                 // numbers of these commands, likewise
  std::uint32_t delay = 0;                            // steps by which the robot file delays the observation, at most
};

/// The numbers themselves, as the network got and gave them: the first ones, where there are more than fit.
struct PolicyVectors {
  Time stamp;
  std::array<float, kMaxPolicyObservation> observation{};
  std::array<float, kMaxPolicyOutput> output{};
  std::uint32_t observed = 0, put_out = 0;  // how many there are
};

template <>
struct Description<PolicyTopic> {
  static constexpr std::string_view name = "PolicyTopic", doc = "One topic as a policy's step found it.";
  static constexpr auto fields = describe(
      field<&PolicyTopic::age_ns>("ns", "from the stamp of the message that went in to the step"),
      field<&PolicyTopic::arrived>("1", "messages since the step before; 1 while both keep pace"),
      field<&PolicyTopic::repeated>("1", "steps so far that saw the same message as the step before"),
      field<&PolicyTopic::skipped>("1", "messages so far that no step saw"),
      field<&PolicyTopic::reordered>("1", "steps so far whose message was stamped before that of the step before"));
};

template <>
struct Description<PolicyState> {
  static constexpr std::string_view name = "PolicyState", doc = "How old the observation of a policy was.";
  static constexpr auto fields = describe(
      field<&PolicyState::stamp>("ns", "of the step"), field<&PolicyState::topic>("", "in the order of the robot file"),
      field<&PolicyState::topics>("1", "in use"),
      field<&PolicyState::clipped>("1", "numbers of this observation at an end of their clip range"),
      field<&PolicyState::clipped_commands>("1", "numbers of these commands, likewise"),
      field<&PolicyState::delay>("1", "steps by which the robot file delays the observation, at most"));
};

template <>
struct Description<PolicyVectors> {
  static constexpr std::string_view name = "PolicyVectors", doc = "What a policy's network got and gave in a step.";
  static constexpr auto fields =
      describe(field<&PolicyVectors::stamp>("ns", "of the step"),
               field<&PolicyVectors::observation>("", "of all inputs but the recurrent ones"),
               field<&PolicyVectors::output>("", "of all outputs but the recurrent ones"),
               field<&PolicyVectors::observed>("1", "numbers of the observation"),
               field<&PolicyVectors::put_out>("1", "numbers of the outputs"));
};

}  // namespace sinew::msg
