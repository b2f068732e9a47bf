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
  /// The step's execution time is used up (commit, emit). May call Schedule::trigger() and announce(), as may start().
  virtual void complete(std::uint32_t thread, std::uint32_t module, Time now) noexcept = 0;
  /// A periodic release met an unfinished cycle: it waits, or it was dropped.
  virtual void overrun(std::uint32_t /*thread*/, Time /*release*/, bool /*dropped*/) noexcept {}
  /// A preempted cycle has a core again.
  virtual void resumed(std::uint32_t /*thread*/, Time /*preempted_at*/, Time /*now*/) noexcept {}
};

/// Thread:  owner.   RT: run_until() allocates nothing.
class Schedule {
 public:
  /// CPU numbers below `cores`, at least one module a thread, positive periods: the graph check has seen to that.
  Schedule(std::vector<ScheduleThread> threads, std::uint32_t cores, Time start, ScheduleClient& client);
  /// A topic or device of this thread triggers it now. From start() and complete(), or between calls of run_until().
  void trigger(std::uint32_t thread);
  /// The device of this thread will be ready at `at` (kNever: unknown). This replaces the earlier announcement; each
  /// one acts once. An instant already passed counts as now.
  void announce(std::uint32_t thread, Time at);
  /// A periodic thread is released at now + k * period from now on, k = 1, 2, ...; waiting cycles go on waiting. Call
  /// from start().
  void restart_period(std::uint32_t thread, Duration period);
  /// Processes everything that happens up to and including `until`.
  void run_until(Time until);
  Time now() const { return now_; }
  const ScheduleCounters& counters(std::uint32_t thread) const { return threads_[thread].counters; }

 private:
  struct Cycle {
    CycleInfo info{};
    bool exists = false;
    bool begun = false;
    bool stepping = false;     // a step is under way, on a core or preempted
    int core = -1;             // -1: does not run
    std::uint32_t module = 0;  // the step under way, or the next one
    std::uint64_t begin_order = 0;
    Duration left{};  // of the step under way, while off a core
    Time ends_at{};   // of the step under way, while on a core
    Time preempted_at = hal::kNever;
  };
  struct Thread {
    ScheduleThread spec;
    std::uint64_t cores = 0;  // bit set
    Cycle cycle;
    std::vector<CycleInfo> waiting;  // ring of catch_up_max (period) or one
    std::uint32_t waiting_first = 0, waiting_count = 0;
    Time next_period = hal::kNever, device_ready = hal::kNever, timeout_at = hal::kNever;
    ScheduleCounters counters;
  };

  Time next_instant() const;
  void process_instant();
  void complete_steps();
  void release(std::uint32_t thread);
  void release_periodic(std::uint32_t thread);
  void act_as_trigger(Thread& thread, bool timed_out);
  void make_cycle(Thread& thread, const CycleInfo& info);
  void finish_cycle(Thread& thread);
  void decide_who_runs();
  int core_for(const Thread& thread, std::uint64_t taken) const;
  bool before(std::uint32_t a, std::uint32_t b) const;
  void start_steps();

  ScheduleClient& client_;
  std::vector<Thread> threads_;
  std::vector<std::uint32_t> order_;  // unfinished cycles, most urgent first
  std::vector<int> running_;          // per core: thread whose cycle runs there, or -1
  Time now_;
  std::uint64_t begins_ = 0;
  bool changed_ = false;  // a cycle was made since it was last decided who runs
};

}  // namespace sinew::rt
