#pragma once
// Only for code that answers requests: it shows the JSON library.
#include <string>
#include <vector>

#include "msg/safety.hpp"
#include "rt/graph_spec.hpp"
#include "tap/newest_message.hpp"
#include "tap/request.hpp"

namespace sinew::tap {

/// What the guardian of a robot says of it, read from its topic as an outsider reads it.
/// Thread:  owner.
/// Owner:   segment and spec outlive it.
class SafetyReader {
 public:
  SafetyReader(const rt::Segment& segment, const rt::GraphSpec& spec);
  /// The newest SafetyState as JSON, with `reasons` why the robot is not armed; null: there is none.
  Json json() const;
  /// Why the robot cannot be armed now, in words.
  std::vector<std::string> not_ready() const;

 private:
  const rt::GraphSpec& spec_;
  NewestMessage<msg::SafetyState> state_;
};

}  // namespace sinew::tap
