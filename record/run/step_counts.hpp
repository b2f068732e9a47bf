#pragma once
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "record/run/step_log.hpp"
#include "rt/exec/stats.hpp"
#include "rt/exec/timeline.hpp"

namespace sinew::record {

/// Counters of threads and modules, and their time line, from the steps of a recorded run. They count what was added:
/// steps that are added twice count twice.
/// Thread:  add(): one; everything else: any.
class StepCounts {
 public:
  StepCounts(std::size_t threads, std::size_t modules);

  /// Steps of one thread, in their order. Steps of threads and modules that there are not are left out.
  void add(std::span<const LoggedStep> steps);

  /// A cycle counts as completed when the next one has begun.
  const rt::ThreadStats& thread(std::size_t i) const { return threads_[i]; }
  rt::ThreadStats& thread(std::size_t i) { return threads_[i]; }
  const rt::ModuleStats& module(std::size_t i) const { return modules_[i]; }
  /// The events of the `last` before `until`, in the order of their beginning. Of many the newest are there.
  std::vector<rt::TimelineEvent> timeline(rt::Time until, rt::Duration last) const;

 private:
  struct Cycle {  // under way
    bool begun = false;
    rt::Time release, first, completed;
  };
  void add(const LoggedStep& step);
  void complete(std::uint32_t thread, Cycle& cycle);
  void put(const rt::TimelineEvent& event);
  void forget(std::uint32_t thread, rt::Time from);

  const std::size_t module_count_;
  std::unique_ptr<rt::ThreadStats[]> threads_;
  std::unique_ptr<rt::ModuleStats[]> modules_;
  std::vector<Cycle> cycles_;  // by thread
  mutable std::mutex mutex_;   // guards events_
  std::deque<rt::TimelineEvent> events_;
};

}  // namespace sinew::record
