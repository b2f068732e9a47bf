#pragma once
// The process around the runtime: children, signals, terminal, resources. For apps; nothing here is for a step.
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/clock.hpp"
#include "hal/result.hpp"

namespace sinew::hal {

/// A program started by us. It gets SIGTERM when we die, so that it is not left behind.
/// Thread:  owner.
class ChildProcess {
 public:
  /// Starts argv[0] (a path) with its output going where ours goes, or to `log_path` when that is not empty.
  /// Errors:  not_found, io.
  static Result<std::unique_ptr<ChildProcess>> start(const std::vector<std::string>& argv,
                                                     const std::string& log_path = {});
  /// Runs `body` in a copy of this process, which ends with its result. The copy outlives us when we die. Only while
  /// this process has one thread: the copy would lack the others, and their locks would stay locked.
  /// Errors:  io; not_supported when there are other threads.
  static Result<std::unique_ptr<ChildProcess>> fork(const std::function<int()>& body);
  ~ChildProcess();  // terminate(), at last kill
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  int pid() const { return pid_; }
  /// The exit code (128 + signal when killed); nothing while it runs.
  std::optional<int> poll();
  /// Waits for the end, at most `patience`.
  std::optional<int> wait(Duration patience);
  /// Asks it to end (SIGTERM).
  void terminate();
  /// Ends it without asking (SIGKILL).
  void kill_now();
  /// In a copy of the owner: the child is no longer ours, and nothing here touches it.
  void disown() { exit_code_ = 0; }

 private:
  explicit ChildProcess(int pid) : pid_(pid) {}
  int pid_;
  std::optional<int> exit_code_;
};

/// "exit code 3", or "signal 11 (Segmentation fault)" for a code of ChildProcess::poll().
std::string describe_exit(int code);

/// From the first call on, SIGINT and SIGTERM do not end the process but make this true.
bool stop_requested();
/// Has the effect of such a signal. Thread: any.
void request_stop();
/// For a program that must survive the loss of its terminal: it ignores a hang-up (SIGHUP), and writing to a pipe
/// without a reader is an error instead of a signal (SIGPIPE). Programs that it starts inherit both.
void outlive_terminal();

/// Writes to standard output as much as fits without waiting, and drops the rest: a stopped terminal, or a pipe without
/// a reader, does not block us. Thread: one at a time; after the bytes that stdio holds.
void print_now(std::string_view text);

/// Is standard output a terminal, and how large (80 x 24 when unknown).
bool output_is_terminal();
bool error_output_is_terminal();
int terminal_columns();
int terminal_rows();

struct ProcessUse {
  Duration cpu{};  // of all threads
  std::uint64_t rss_bytes = 0;
  std::uint64_t peak_rss_bytes = 0;
};
ProcessUse process_use();

/// When this process was started, before its first instruction, on system_os()'s clock, to 10 ms. Nothing when the
/// kernel does not say.
std::optional<Time> process_start();

/// The running program's own path; empty when the kernel does not say.
std::string program_path();

/// Processors of the machine that this process may use.
std::uint32_t usable_cpus();

}  // namespace sinew::hal
