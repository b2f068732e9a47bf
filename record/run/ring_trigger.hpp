#pragma once
#include <optional>
#include <string>
#include <vector>

#include "msg/safety.hpp"
#include "record/run/step_log.hpp"
#include "rt/graph.hpp"

namespace sinew::record {

/// Finds the events whose last seconds are worth keeping: a missed deadline, a faulted step, an act of the guardian.
/// Answers in words, from the entries of the log.
/// Thread:  owner.
class RingTrigger {
 public:
  explicit RingTrigger(const rt::Graph& graph);
  std::optional<std::string> step(const LoggedStep& step);
  void request(const LoggedRequest& request);
  /// Call for every message of the topic that is_safety() names.
  bool is_safety(std::uint32_t topic) const { return topic == safety_; }
  std::optional<std::string> safety(const msg::SafetyState& state);

 private:
  const rt::Graph& graph_;
  std::vector<rt::Duration> period_;  // per thread; 0: it has no deadline
  std::vector<rt::Time> missed_;      // per thread: the last missed release
  std::uint32_t safety_ = rt::kNone;
  std::uint32_t acted_ = 0;
  msg::GuardianMode mode_ = msg::GuardianMode::standby;
};

}  // namespace sinew::record
