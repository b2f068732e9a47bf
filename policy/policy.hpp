#pragma once
#include <memory>
#include <string>
#include <vector>

#include "msg/policy.hpp"
#include "policy/plan.hpp"
#include "rt/module.hpp"

namespace sinew::policy {

/// A policy trained elsewhere: a network out of an ONNX file, fed with fields of topics, whose outputs are fields of
/// commands (docs/policies.md). One step is one run of the network.
///
/// Inputs:  one for each topic that is observed: its newest message, named topic_port(topic).
/// Outputs: one for each `to` of the commands, of the type of the input that reads it ("motor": the guardian's
///          ActuatorCommand). `state`: how old the observation was, each step. `vectors`: the numbers themselves, when
///          publish_vectors says so.
/// State:   earlier observations and commands, as far as history and delay need them, and what the network carries from
///          step to step.
/// Thread:  executor.   RT: yes.
/// Errors:  step: stale while a topic has no message, or none that is fresh; fault when a number that goes in or comes
///          out is not finite. Nothing is published or remembered then, and the guardian acts when the lease runs out.
///          configure: bad_argument, with all problems in words.
class Policy final : public rt::Module {
 public:
  Policy(PolicyOptions options, std::shared_ptr<const PolicyFile> file);
  ~Policy() override;

  void declare(rt::Declaration& d) override;
  hal::Status configure(rt::Setup& setup) override;
  void reset() override;
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  /// State of one topic.
  struct Seen {
    rt::Time stamp{};
    std::uint32_t any = 0, sequence = 0;
    msg::PolicyTopic counts{};
  };
  struct Output;

  bool sample() noexcept;
  void remember() noexcept;
  bool run() noexcept;
  void look_at_topics(rt::Time now) noexcept;
  void publish(rt::Time now) noexcept;
  float value_of(std::uint32_t source, std::uint32_t age) const noexcept;

  const PolicyOptions options_;
  const std::shared_ptr<const PolicyFile> file_;
  std::unique_ptr<onnx::Network> network_;
  Plan plan_;
  bool publish_vectors_ = false;

  std::vector<std::unique_ptr<rt::AnyIn>> in_;  // bound by address, as plan_.topics
  std::vector<std::unique_ptr<Output>> out_;
  rt::Out<msg::PolicyState> state_;
  rt::Out<msg::PolicyVectors> vectors_;
  std::vector<float> now_, commands_;  // of this step: each source, each command
  std::uint32_t clipped_ = 0, clipped_commands_ = 0;

  // State:
  std::vector<float> past_;     // by source: newest first
  std::vector<float> sent_;     // by command: newest first
  std::vector<float> carried_;  // recurrent values, one after the other
  std::vector<float> put_out_;  // the outputs of the step before, where they are observed
  std::vector<Seen> seen_;
  std::uint32_t began_ = 0;
};

}  // namespace sinew::policy
