#pragma once
// The fixed-priority preemptive schedule in virtual time, apart from what the steps do. Definition: rt/README.md.
#include <cstdint>
#include <vector>

#include "hal/clock.hpp"
#include "rt/graph_spec.hpp"

namespace sinew::rt {

/// What the schedule needs to know of a thread. Index in the vector = order of the file (the guardian comes first).
struct ScheduleThread {
  int priority = 0;
  std::vector<int> cpus;  // empty: all virtual cores
  ThreadSpec::Trigger trigger = ThreadSpec::Trigger::period;
  Duration period{}, phase{}, timeout{};
  ThreadSpec::Overrun overrun = ThreadSpec::Overrun::skip;
  std::uint32_t catch_up_max = 1;
  std::uint32_t modules = 1;
};

struct CycleInfo {
  Time release;    // scheduled instant of the release (period) or instant of the trigger
  bool timed_out;  // released by the time-out
};

struct ScheduleCounters {
  std::uint64_t releases = 0;     // cycles that began or wait to begin
  std::uint64_t completions = 0;  // cycles completed
  std::uint64_t overruns = 0;     // periodic releases that met an unfinished cycle
  std::uint64_t skips = 0;        // periodic releases dropped
  std::uint64_t coalesced = 0;    // triggers that did not get a cycle of their own
  std::uint64_t timeouts = 0;     // cycles released by the time-out
  std::uint64_t preemptions = 0;  // times a begun cycle lost its core
};

/// What happens at the instants of the schedule.
class ScheduleClient {
 public:
  virtual ~ScheduleClient() = default;
  /// A step starts (collect, latch, step). Returns how long it executes; less than 1 ns counts as 1 ns.
  virtual Duration start(std::uint32_t thread, std::uint32_t module, const CycleInfo& cycle, Time now) noexcept = 0;
  /// The step's execution time is used up (commit, emit). May call Schedule::trigger().
  virtual void complete(std::uint32_t thread, std::uint32_t module, Time now) noexcept = 0;
};

/// Thread:  owner.   RT: run_until() allocates nothing.
class Schedule {
 public:
  Schedule(std::vector<ScheduleThread> threads, std::uint32_t cores, Time start, ScheduleClient& client);
  /// A topic or device of this thread triggers it now. From complete(), or between calls of run_until().
  void trigger(std::uint32_t thread);
  /// The device of this thread will be ready at `at` (kNever: unknown); replaces what was announced before. An instant
  /// already passed counts as now.
  void announce(std::uint32_t thread, Time at);
  /// Processes everything that happens up to and including `until`.
  void run_until(Time until);
  Time now() const;
  const ScheduleCounters& counters(std::uint32_t thread) const;

 private:
  struct Impl;
};

}  // namespace sinew::rt
