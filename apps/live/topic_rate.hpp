#pragma once
// How regularly a topic is published, from the sequence numbers and publish times of its messages.
#include <cstdint>
#include <vector>

#include "msg/time.hpp"

namespace sinew::app {

struct TopicRate {
  std::uint64_t messages = 0, lost = 0;  // lost: sequence numbers never seen
  double rate_hz = 0;  // of the writer, lost messages included; 0: unknown, with fewer than two messages
  msg::Duration interval_p50{}, interval_max{};
  msg::Duration jitter_p50{}, jitter_p99{};  // how far intervals are from their median
};

/// Thread:  owner.
class RateMeter {
 public:
  /// Messages in their order. Sequence numbers may wrap.
  void add(std::uint32_t sequence, msg::Time published);
  /// Only neighbours make an interval: one that spans a loss says nothing about the writer.
  TopicRate result() const;

 private:
  std::uint64_t messages_ = 0, lost_ = 0;
  std::uint32_t last_sequence_ = 0;
  msg::Time first_{}, last_{};
  std::vector<std::int64_t> intervals_ns_;
};

}  // namespace sinew::app
