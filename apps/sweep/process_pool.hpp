#pragma once
// Cases in processes of their own, several at a time: one that crashes or hangs is a result, not the end of the rest.
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/clock.hpp"
#include "hal/linux/temporary_folder.hpp"

namespace sinew::sweep {

/// What one process does. Its standard input is empty.
struct Job {
  std::vector<std::string> argv{};  // a program (a path) and its arguments; empty: `body` instead
  std::function<int()> body{};      // called in a copy of this process, which ends with its result as exit code
};

struct JobResult {
  int code = 0;       // exit code, 128 + signal of a process that a signal ended; 128 + 9: it hung; 127: not started
  bool hung = false;  // it was ended after the patience
  std::string output{}, errors{};  // the last kMostOutput bytes that it wrote to standard output and standard error
  std::string not_started{};       // why there was no process, which says nothing about the case; empty: there was one
};

/// "exit code 3", "crashed: signal 11 (Segmentation fault)", "hung", or why it was not started.
std::string describe_end(const JobResult& result);

/// Starts processes as earlier ones end. A process that has ended takes the ones that it started with it. While the
/// pool lives, TMPDIR of this process is a folder of its own, in which killed cases leave nothing behind; the folder of
/// a pool that was killed is removed by the next pool.
///
/// Thread:  owner, with no other thread that reads or writes the environment while it is made and ended; for jobs with
///          a `body` the only thread of the process.
class ProcessPool {
 public:
  enum class Order : std::uint8_t { as_they_end, as_they_began };
  static constexpr std::size_t kMostOutput = 64 << 10;
  static constexpr std::size_t kMostAhead = 4096;  // results that wait for an earlier one, with Order::as_they_began

  /// `jobs`: at a time; 0: one for each processor. Fewer where this process may not open three files for each.
  /// `patience`: of real time, for each job.
  ProcessPool(unsigned jobs, hal::Duration patience);
  ~ProcessPool();
  ProcessPool(const ProcessPool&) = delete;
  ProcessPool& operator=(const ProcessPool&) = delete;

  /// The next job; nothing: there is none, and it is not called again.
  using Next = std::function<std::optional<Job>()>;
  /// Takes the result of the job that Next gave as the `number`th of this run(), counted from 0. False: stop.
  using Done = std::function<bool(std::uint64_t number, const JobResult& result)>;

  /// Runs until all jobs are done, `done` answers false, or hal::stop_requested(). Those under way are then ended, with
  /// the processes that they started. False: it did not go through to the end. Waits without polling where the kernel
  /// can (pidfd, Linux 5.3).
  bool run(const Next& next, const Done& done, Order order = Order::as_they_end);

  unsigned jobs() const { return jobs_; }
  std::uint64_t started() const { return started_; }  // in all run(), with those that could not be started

 private:
  unsigned jobs_;
  const hal::Duration patience_;
  std::unique_ptr<hal::TemporaryFolder> folder_{};  // of its jobs; null: it could not be made
  std::optional<std::string> tmpdir_{};             // TMPDIR before
  std::uint64_t started_ = 0;
};

}  // namespace sinew::sweep
