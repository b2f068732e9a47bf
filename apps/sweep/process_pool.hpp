#pragma once
// Cases in processes of their own, several at a time: one that crashes or hangs is a result, not the end of the rest.
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "hal/clock.hpp"

namespace sinew::sweep {

/// What one process does.
struct Job {
  std::vector<std::string> argv{};  // a program (a path) and its arguments; empty: `body` instead
  std::function<int()> body{};      // called in a copy of this process, which ends with its result as exit code
};

struct JobResult {
  int code = 0;                    // exit code, 128 + signal of a process that a signal ended; 128 + 9 when it hung
  bool hung = false;               // it was killed after the patience
  std::string output{}, errors{};  // the last kMostOutput bytes that it wrote to standard output and standard error
  std::string not_started{};       // why there was no process; empty: there was one
};

/// Starts processes as earlier ones end. While it lives, TMPDIR of this process is a folder of its own, in which killed
/// cases leave nothing behind.
/// Thread:  owner, with no other thread that reads or writes the environment while it is made and ended; for jobs with
/// a
///          `body` the only thread of the process.
class ProcessPool {
 public:
  enum class Order : std::uint8_t { as_they_end, as_they_began };
  static constexpr std::size_t kMostOutput = 64 << 10;

  /// `jobs`: at a time; 0: one for each processor. `patience`: of real time, for each job.
  ProcessPool(unsigned jobs, hal::Duration patience);
  ~ProcessPool();
  ProcessPool(const ProcessPool&) = delete;
  ProcessPool& operator=(const ProcessPool&) = delete;

  /// The next job; nothing: there is none.
  using Next = std::function<std::optional<Job>()>;
  /// Takes the result of the job that Next gave as the `number`th, counted from 0. False: stop.
  using Done = std::function<bool(std::uint64_t number, const JobResult& result)>;

  /// Runs until all jobs are done, `done` answers false, or hal::stop_requested(). Those under way are then ended, with
  /// the processes that they started. False: it did not go through to the end. Waits without polling where the kernel
  /// can (pidfd, Linux 5.3).
  bool run(const Next& next, const Done& done, Order order = Order::as_they_end);

  std::uint64_t started() const { return started_; }

 private:
  std::uint64_t started_ = 0;
};

}  // namespace sinew::sweep
