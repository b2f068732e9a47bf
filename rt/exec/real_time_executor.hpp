#pragma once
#include <memory>
#include <string>
#include <vector>

#include "hal/os.hpp"
#include "rt/exec/gap_watch.hpp"
#include "rt/exec/runner.hpp"
#include "rt/graph.hpp"

namespace sinew::rt {

struct RealTimeOptions {
  Duration start_delay = std::chrono::milliseconds(20);  // to the first release, once all threads are there
  bool lock_memory = true;
  bool strict = false;         // start() refuses where there is a shortfall
  bool keep_awake = true;      // processors stay out of idle states that they wake from slowly
  Throttle throttle{};         // of this kernel, to recognise its gaps in the timing
  bool fixed_priority = true;  // false: ordinary priority for all, for machines where SCHED_FIFO only disturbs
  // Precise wake-up (thread option `precise`): the look at the clock begins at most this long before the release.
  Duration precise_tail_max = std::chrono::microseconds(100);
  RunnerOptions runner{};  // `start` and `clock` are set by start()
};

/// Runs a configured graph in real time: one OS thread for each graph thread, at its priority, on its CPUs. The
/// schedule is that of rt/README.md as far as the kernel allows. A late cycle is counted with its lateness and never
/// shifts later periods.
/// Thread:  owner.   RT: its threads allocate nothing and take no lock.
class RealTimeExecutor {
 public:
  /// Registers itself with the devices that trigger threads, so construct it before the board is started.
  RealTimeExecutor(Graph& graph, hal::Os& os, const RealTimeOptions& options = {});
  ~RealTimeExecutor();  // stop()
  RealTimeExecutor(const RealTimeExecutor&) = delete;
  RealTimeExecutor& operator=(const RealTimeExecutor&) = delete;

  /// Makes all threads; when all shortfalls are known, releases the threads together. Errors: those of starting a
  /// thread; a processor that does not round as fp_mode.hpp wants; with `strict`, denied where there are shortfalls().
  /// After an error no thread runs, and no module has taken a step.
  hal::Status start();
  /// Asks all threads to end after their cycle, waits for them, and then stops all actuators.
  void stop();

  Time started_at() const { return start_; }
  /// Missing privileges and CPUs, one line each; without `strict` the robot runs all the same.
  const std::vector<std::string>& shortfalls() const { return shortfalls_; }
  /// After start().
  Runner& runner() { return *runner_; }

 private:
  class Worker;
  void release() noexcept;
  void await_release() noexcept;
  bool any_busy(Time now) const noexcept;
  void fire(std::span<const std::uint32_t> topics, Time now) noexcept;

  Graph& graph_;
  hal::Os& os_;
  RealTimeOptions options_;
  Time start_{};
  hal::WakeWord released_{0};  // 1: the threads may begin, at start_, or end
  std::unique_ptr<Runner> runner_;
  std::vector<std::unique_ptr<Worker>> workers_;
  std::shared_ptr<void> awake_;  // processors, while it runs
  bool started_ = false;
  std::vector<std::string> shortfalls_;
};

}  // namespace sinew::rt
