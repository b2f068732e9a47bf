#pragma once
// Virtual time: the whole graph on one OS thread, by the exact schedule of rt/README.md.
#include <atomic>
#include <vector>

#include "hal/board.hpp"
#include "hal/os.hpp"
#include "rt/exec/runner.hpp"
#include "rt/exec/schedule.hpp"

namespace sinew::rt {

struct DiscreteOptions {
  Time start{};
  Duration duration{INT64_MAX};  // virtual time to run; the source may end the run before
  hal::Os* os = nullptr;         // for its CPU time; needed when a module's execution time is `measured`
  bool hash_topics = false;
  std::uint32_t fault_limit = 10;  // see RunnerOptions
  RunObserver* observer = nullptr;
};

struct DiscreteReport {
  enum class End : std::uint8_t { duration, source_closed, stop_requested, source_failed };
  End end = End::duration;
  Time reached;        // virtual time
  hal::Error error{};  // source_failed
};

/// Runs a configured graph: grant, announce devices, run to the grant, again. The same grants, devices and execution
/// times give the same bytes on every topic.
/// Thread:  owner; request_stop(): any.
/// RT:      run() allocates nothing.
class DiscreteExecutor final : private ScheduleClient {
 public:
  /// `clock` is set to the instant of every event before a module or device is called. All must outlive the executor.
  DiscreteExecutor(Graph& graph, hal::ManualClock& clock, hal::GrantSource& grants,
                   const DiscreteOptions& options = {});
  /// Once.
  /// Errors:  not_supported: an execution time is to be measured and there is no Os, or the processor does not round as
  ///          fp_mode.hpp wants. The report says what ended the run.
  hal::Result<DiscreteReport> run();
  /// The run ends at the next grant.
  void request_stop() noexcept { stop_.store(true, std::memory_order_relaxed); }

  Runner& runner() { return runner_; }
  const ScheduleCounters& counters(std::uint32_t thread) const { return schedule_.counters(thread); }

 private:
  Duration start(std::uint32_t thread, std::uint32_t position, const CycleInfo& cycle, Time now) noexcept override;
  void complete(std::uint32_t thread, std::uint32_t position, Time now) noexcept override;
  void overrun(std::uint32_t thread, Time release, bool dropped) noexcept override;
  void resumed(std::uint32_t thread, Time preempted_at, Time now) noexcept override;

  struct Model {  // of one module's execution time
    const ExecModel* exec;
    std::uint32_t stream;  // of its draws
    std::size_t next = 0;  // of the trace
    Duration now{};        // of the step under way
  };
  DiscreteReport run_to_end();
  Duration model_time(Model& model, Duration measured, std::uint32_t step);
  void trigger_readers(std::span<const std::uint32_t> topics) noexcept;
  void announce_all() noexcept;
  void announce(std::uint32_t thread, Time ready) noexcept;
  void copy_counters() noexcept;

  Graph& graph_;
  hal::ManualClock& clock_;
  hal::GrantSource& grants_;
  DiscreteOptions options_;
  Runner runner_;
  Schedule schedule_;
  std::vector<Model> models_;         // per module
  std::vector<hal::Device*> device_;  // per thread; null: no device trigger
  std::vector<Time> announced_;       // per thread: the instant that the device announced last
  std::atomic<bool> stop_{false};
};

}  // namespace sinew::rt
