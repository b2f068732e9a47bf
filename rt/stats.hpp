#pragma once
// Counters and histograms of a run. Written by the executor's threads, read by anybody: values are single words written
// by one thread each, so a reader sees each number whole but not all of one instant.
#include <array>
#include <atomic>
#include <cstdint>

#include "msg/time.hpp"

namespace sinew::rt {

using msg::Duration;

/// Log-linear histogram of durations: 16 buckets per octave from 1 ns to about 18 minutes, relative error under 1/16.
/// Thread:  one writer, any readers.   RT: yes.
class Histogram {
 public:
  void add(Duration d) noexcept;
  std::uint64_t count() const noexcept;
  Duration min() const noexcept;
  Duration max() const noexcept;
  double mean_ns() const noexcept;
  /// Upper bound of the bucket that holds the quantile q in [0, 1], but never more than max(); 0 when empty.
  Duration quantile(double q) const noexcept;

 private:
  static constexpr std::size_t kSub = 16, kBuckets = kSub * 38;
  std::array<std::atomic<std::uint32_t>, kBuckets> bucket_{};
  std::atomic<std::uint32_t> count_{0};
  std::atomic<std::int64_t> min_{INT64_MAX}, max_{0};  // 64-bit: private memory only
  std::atomic<std::int64_t> sum_{0};
};

}  // namespace sinew::rt
