#pragma once
// Only for code that answers requests: it shows the JSON library.
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "msg/safety.hpp"
#include "rt/graph_spec.hpp"
#include "tap/request.hpp"
#include "tap/segment_reader.hpp"

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
  std::optional<msg::SafetyState> newest() const;

  const rt::GraphSpec& spec_;
  std::optional<SegmentReader> reader_;
  std::optional<std::uint32_t> topic_;
};

}  // namespace sinew::tap
