#pragma once
#include <vector>

#include "apps/search/verdict.hpp"
#include "rt/exec/runner.hpp"

namespace sinew::search {

/// Checks the steps and counters of a run. Invariants:
///   phase     a periodic thread is released on its own grid and nowhere else; dt is release to release
///   steps     a module's steps are numbered without a gap, and each is ok, stale or fault
///   counters  every period that passed is a release or a skip; every release is a completion, under way or waiting;
///             every completed cycle is one step of each of its modules
/// Thread:  owner.
class ScheduleCheck {
 public:
  ScheduleCheck(const rt::Graph& graph, Verdict& verdict);
  void completed(const rt::StepRecord& record);
  /// Between two grants, everything up to and including `now` done.
  void look(msg::Time now, rt::Runner& runner);

 private:
  struct Seen {
    std::uint32_t steps = 0;
    msg::Time release{-1};
  };
  void check_periodic(const rt::StepRecord& record, const Seen& seen);
  void check_thread(msg::Time now, std::uint32_t thread, const rt::ThreadStats& stats);
  void check_module(msg::Time now, std::uint32_t module, const rt::ModuleStats& stats, std::uint64_t completions);

  const rt::Graph& graph_;
  Verdict& verdict_;
  std::vector<Seen> seen_;  // per module
};

}  // namespace sinew::search
