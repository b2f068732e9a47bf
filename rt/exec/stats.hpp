#pragma once
// Counters and histograms of a run. The executor's threads write them, any thread reads them. Each value is a single
// word with one writer: a reader sees each number whole, but not all numbers of one instant.
#include <array>
#include <cstdint>

#include "hal/wide.hpp"
#include "msg/time.hpp"

namespace sinew::rt {

using msg::Duration;
using msg::Time;

/// A number that one thread writes and any thread reads.
/// Thread:  one writer, any readers; nothing is ordered by it.   RT: yes.
template <class V>
class Counter {
 public:
  V value() const noexcept { return value_.load(); }
  void set(V v) noexcept { value_.store(v); }
  void add(V v = 1) noexcept { set(value() + v); }

 private:
  hal::Wide<V> value_;
};
using Count = Counter<std::uint64_t>;

/// Log-linear histogram of durations: 16 buckets per octave from 1 ns to about 36 minutes, relative error under 1/16.
/// Negative durations count as 0, longer ones as the longest.
/// Thread:  one writer, any readers.   RT: yes.
class Histogram {
 public:
  void add(Duration d) noexcept;
  std::uint64_t count() const noexcept { return count_.value(); }
  Duration min() const noexcept { return Duration{count() ? min_.value() : 0}; }
  Duration max() const noexcept { return Duration{max_.value()}; }
  double mean_ns() const noexcept;
  /// Upper bound of the bucket that holds the quantile q in [0, 1] (the ceil(q * count)-th value in order), but never
  /// more than max(); 0 when empty.
  Duration quantile(double q) const noexcept;

 private:
  static constexpr std::size_t kSub = 16, kBuckets = kSub * 38;
  static std::size_t bucket_of(std::uint64_t ns) noexcept;
  static std::uint64_t upper_bound(std::size_t bucket) noexcept;

  std::array<Counter<std::uint32_t>, kBuckets> bucket_{};
  Count count_;
  Counter<std::int64_t> min_, max_, sum_;
};

/// Times in which a thread was ready without a processor, each far longer than any wake-up (GapWatch::kGap).
struct GapStats {
  Count count;
  Counter<std::int64_t> min_ns, max_ns;
  void add(Duration length, std::uint32_t times) noexcept;
};

struct ThreadStats {
  Count releases, completions, overruns, skips, coalesced, timeouts;
  Counter<std::int64_t> period_ns;  // now in force; 0: the thread has none
  Count preemptions;                // virtual time only: the kernel does not tell a thread
  GapStats throttled, taken;        // real time only: gaps like those of the kernel's throttle; all other gaps
  Histogram lateness;               // release to start of the first step
  Histogram exec;                   // first start to completion of the cycle, preemption included
};

struct ModuleStats {
  Count steps, ok, stale, fault;
  Count stops;                     // stopped for too many faults in a row
  Counter<std::uint32_t> stopped;  // 1: not stepped, because it was stopped or disabled
  Count best_effort_calls;         // trapped calls of a best-effort module, in builds with the trap
  Count fp_mode_changes;           // steps that left another floating-point mode behind; it is put right again
  Histogram exec;                  // execution time of the step; virtual: what its model said
};

struct ChainStats {
  Histogram age;  // at the commit of the chain's last topic: commit instant minus origin
  Count budget_misses;
};

struct TopicStats {
  Count messages;
  Counter<std::int64_t> last_stamp_ns, last_published_ns;
  Histogram age;  // published minus stamp
};

}  // namespace sinew::rt
