#pragma once
// The process around the runtime: children, signals, terminal, resources. For apps; nothing here is for a step.
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/clock.hpp"
#include "hal/result.hpp"

namespace sinew::hal {

struct Pipe;

/// What a child has of us, and how it hears of what happens to us.
struct ChildOptions {
  std::string log_path{};           // where its output goes; empty: where ours goes
  bool piped = false;               // true: read_output() reads its output, and its input is empty
  bool hears_terminal = true;       // false: Ctrl-C, which a terminal sends to all of its processes, is for us alone
  bool own_group = false;           // true: the same, and processes that it started and left behind end with it
  bool killed_when_we_die = false;  // true: SIGKILL instead of SIGTERM, which a stopped process does not heed
};

/// A program started by us. It gets a signal when we die, so that it is not left behind.
/// Thread:  owner.
class ChildProcess {
 public:
  /// Starts argv[0] (a path).
  /// Errors:  not_found, io.
  static Result<std::unique_ptr<ChildProcess>> start(const std::vector<std::string>& argv, const ChildOptions& options);
  static Result<std::unique_ptr<ChildProcess>> start(const std::vector<std::string>& argv,
                                                     const std::string& log_path = {}) {
    return start(argv, ChildOptions{.log_path = log_path});
  }
  /// Runs `body` in a copy of this process, which ends with its result. The copy outlives us when we die. Only while
  /// this process has one thread: the copy would lack the others, and their locks would stay locked.
  /// Errors:  io; not_supported when there are other threads.
  static Result<std::unique_ptr<ChildProcess>> fork(const std::function<int()>& body);
  /// The same, but the copy is like a program that was started: it gets a signal when we die, and SIGINT and SIGTERM
  /// end it, whatever they do to us.
  static Result<std::unique_ptr<ChildProcess>> fork(const std::function<int()>& body, const ChildOptions& options);
  ~ChildProcess();  // terminate(), at last kill
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  int pid() const { return pid_; }
  /// The exit code (128 + signal when killed); nothing while it runs, or is stopped.
  std::optional<int> poll();
  /// As of the last poll(): a signal (SIGSTOP, Ctrl-Z) has stopped it, and none has continued it.
  bool is_stopped() const { return stopped_; }
  /// Waits for the end, at most `patience`.
  std::optional<int> wait(Duration patience);
  /// Waits until one of these piped children has ended, has written to its pipes or closed them, at most `patience` or
  /// until a signal comes; replaces `ready` by the indices of those to look at with poll() and read_output(). It may
  /// name one that has nothing new: a kernel without pidfd (Linux before 5.3) reports no ends, so all are looked at
  /// every 3 ms.
  static void wait_for_any(std::span<ChildProcess* const> children, Duration patience, std::vector<std::size_t>& ready);
  /// Of a piped child: appends what it has written to standard output and standard error by now, at most 64 KiB of each
  /// at a time, without waiting. False: there is no more for now.
  bool read_output(std::string& output, std::string& errors);
  /// Asks it to end (SIGTERM).
  void terminate();
  /// Ends it without asking (SIGKILL), with its own group.
  void kill_now();
  /// In a copy of the owner: the child is no longer ours, and nothing here touches it.
  void disown() { exit_code_ = 0; }

 private:
  explicit ChildProcess(int pid) : pid_(pid) {}
  static Result<std::unique_ptr<ChildProcess>> copy(const std::function<int()>& body, const ChildOptions* options);
  void watch(const ChildOptions& options, Pipe& output, Pipe& errors);  // takes their read ends
  void end_group();
  int pid_;
  bool own_group_ = false;
  int output_ = -1, errors_ = -1;  // ends of pipes; -1: not piped, or all who could write have closed it
  int end_ = -1;                   // readable once the child has ended; -1: the kernel has none
  std::optional<int> exit_code_;
  bool stopped_ = false;
};

/// "exit code 3", or "signal 11 (Segmentation fault)" for a code of ChildProcess::poll().
std::string describe_exit(int code);

/// From the first call on, SIGINT and SIGTERM do not end the process but make this true.
bool stop_requested();
/// How many such signals came, of those that come within kOneSignal only one: `timeout` and a terminal may send one
/// twice.
unsigned stop_signals();
inline constexpr Duration kOneSignal = std::chrono::milliseconds(250);
/// The second of these signals ends the process at once, with `last_words` on standard error and exit code 1; null: it
/// does not, which is the default. Owner: `last_words` for ever.
void end_at_second_signal(const char* last_words);
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

/// When this program was loaded, before its main(), on system_os()'s clock. Later than process_start() in a process
/// that ran something else before, such as the script that ended with `exec`; in a copy (ChildProcess::fork()) that of
/// the original.
Time program_start();

/// Whether there is a process with this number, of any user.
bool process_exists(int pid);

/// The running program's own path; empty when the kernel does not say.
std::string program_path();

/// Processors of the machine that this process may use.
std::uint32_t usable_cpus();

/// How many files this process may have open at a time.
std::size_t most_open_files();

}  // namespace sinew::hal
