#include "hal/linux/process.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "hal/linux/beyond_posix.hpp"
#include "hal/platform.hpp"

namespace sinew::hal {
namespace {

std::atomic<bool> g_stop{false};
std::atomic<unsigned> g_signals{0};
std::atomic<std::uint32_t> g_signal_ms{0};  // when the last one counted; wraps
std::atomic<const char*> g_last_words{nullptr};
const Time g_loaded = system_os().now();  // initialised before main()

// Only calls that are safe in a handler of signals.
void on_signal(int) {
  const int kept = errno;
  g_stop.store(true, std::memory_order_relaxed);
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  const auto now_ms = static_cast<std::uint32_t>(std::int64_t{now.tv_sec} * 1000 + now.tv_nsec / 1'000'000);
  if (g_signals.load(std::memory_order_relaxed) == 0 ||
      std::chrono::milliseconds(now_ms - g_signal_ms.load(std::memory_order_relaxed)) > kOneSignal) {
    g_signal_ms.store(now_ms, std::memory_order_relaxed);
    const char* const words = g_last_words.load(std::memory_order_relaxed);
    if (g_signals.fetch_add(1, std::memory_order_relaxed) > 0 && words) {
      [[maybe_unused]] const auto n = write(STDERR_FILENO, words, strlen(words));
      _exit(1);
    }
  }
  errno = kept;
}

// Our parent may have set SIGCHLD to ignore; then no end of a child would ever be reported.
void hear_of_children() { std::signal(SIGCHLD, SIG_DFL); }

// Between fork and exec: only calls that are safe there.
[[noreturn]] void become(const std::vector<char*>& argv, const ChildOptions& options, int report_fd, pid_t parent) {
  beyond_posix::end_with_parent(options.killed_when_we_die ? SIGKILL : SIGTERM);
  if (getppid() != parent) _exit(127);
  if (!options.hears_terminal) signal(SIGINT, SIG_IGN);
  if (!options.log_path.empty()) {
    const int fd = open(options.log_path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (fd >= 0) {
      dup2(fd, 1);
      dup2(fd, 2);
    }
  }
  execv(argv[0], argv.data());
  const int error = errno;
  [[maybe_unused]] const auto n = write(report_fd, &error, sizeof(error));
  _exit(127);
}

}  // namespace

Result<std::unique_ptr<ChildProcess>> ChildProcess::start(const std::vector<std::string>& argv,
                                                          const ChildOptions& options) {
  hear_of_children();
  std::vector<char*> raw;
  for (const auto& a : argv) raw.push_back(const_cast<char*>(a.c_str()));
  raw.push_back(nullptr);
  int report[2];  // closed by a successful exec; otherwise carries its errno
  if (pipe2(report, O_CLOEXEC) != 0) return Error{Errc::io, "pipe2", errno};
  const pid_t parent = getpid();
  const pid_t pid = ::fork();
  if (pid == 0) become(raw, options, report[1], parent);
  const int fork_error = errno;
  close(report[1]);
  if (pid < 0) {
    close(report[0]);
    return Error{Errc::io, "fork", fork_error};
  }
  int error = 0;
  ssize_t got = 0;
  do got = read(report[0], &error, sizeof(error));
  while (got < 0 && errno == EINTR);
  close(report[0]);
  if (got == sizeof(error)) {
    while (waitpid(pid, nullptr, 0) < 0 && errno == EINTR) {
    }
    return Error{error == ENOENT ? Errc::not_found : Errc::io, "exec", error};
  }
  return std::unique_ptr<ChildProcess>(new ChildProcess(pid));
}

Result<std::unique_ptr<ChildProcess>> ChildProcess::fork(const std::function<int()>& body) {
  const std::size_t threads = beyond_posix::threads();
  if (threads > 1) return Error{Errc::not_supported, "fork with more than one thread", std::int64_t(threads)};
  hear_of_children();
  std::fflush(nullptr);  // otherwise both would write the buffered bytes
  const pid_t pid = ::fork();
  if (pid < 0) return Error{Errc::io, "fork", errno};
  if (pid > 0) return std::unique_ptr<ChildProcess>(new ChildProcess(pid));
  std::exit(body());
}

std::optional<int> ChildProcess::poll() {
  int status = 0;
  while (!exit_code_ && waitpid(pid_, &status, WNOHANG | WUNTRACED | WCONTINUED) == pid_) {
    stopped_ = WIFSTOPPED(status);
    if (WIFSTOPPED(status) || WIFCONTINUED(status)) continue;
    exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  return exit_code_;
}

std::optional<int> ChildProcess::wait(Duration patience) {
  Os& os = system_os();
  const Time end = os.now() + patience;
  while (!poll() && os.now() < end) os.sleep_until(os.now() + std::chrono::milliseconds(2));
  return poll();
}

void ChildProcess::terminate() {
  if (!poll()) kill(pid_, SIGTERM);
}

void ChildProcess::kill_now() {
  if (!poll()) kill(pid_, SIGKILL);
}

ChildProcess::~ChildProcess() {
  terminate();
  if (wait(std::chrono::seconds(2))) return;
  kill_now();
  wait(std::chrono::seconds(2));
}

std::string describe_exit(int code) {
  if (code <= 128) return "exit code " + std::to_string(code);
  return "signal " + std::to_string(code - 128) + " (" + strsignal(code - 128) + ")";
}

Time program_start() { return g_loaded; }

bool process_exists(int pid) { return pid > 0 && (::kill(pid, 0) == 0 || errno == EPERM); }

bool stop_requested() {
  static const bool installed = [] {
    struct sigaction action {};
    action.sa_handler = on_signal;
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
    return true;
  }();
  return installed && g_stop.load(std::memory_order_relaxed);
}

unsigned stop_signals() { return g_signals.load(std::memory_order_relaxed); }

void end_at_second_signal(const char* last_words) { g_last_words.store(last_words, std::memory_order_relaxed); }

void outlive_terminal() {
  std::signal(SIGHUP, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
}

void print_now(std::string_view text) {
  std::fflush(stdout);
  // A separate opening does not wait, while other users of the terminal still do. Writing to a file never waits.
  static const int out = [] {
    struct stat info {};
    const bool may_wait = fstat(STDOUT_FILENO, &info) == 0 && (S_ISCHR(info.st_mode) || S_ISFIFO(info.st_mode));
    const int own =
        may_wait ? beyond_posix::open_again(STDOUT_FILENO, O_WRONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC) : -1;
    return own < 0 ? STDOUT_FILENO : own;
  }();
  static_cast<void>(write(out, text.data(), text.size()) < 0);  // on an error the text is lost
}

void request_stop() { g_stop.store(true, std::memory_order_relaxed); }

bool output_is_terminal() { return isatty(STDOUT_FILENO) == 1; }
bool error_output_is_terminal() { return isatty(STDERR_FILENO) == 1; }

int terminal_columns() {
  winsize size{};
  return ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

int terminal_rows() {
  winsize size{};
  return ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_row > 0 ? size.ws_row : 24;
}

ProcessUse process_use() {
  ProcessUse use;
  rusage r{};
  if (getrusage(RUSAGE_SELF, &r) == 0) {
    const auto to_ns = [](const timeval& t) { return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_usec * 1000; };
    use.cpu = Duration{to_ns(r.ru_utime) + to_ns(r.ru_stime)};
    use.peak_rss_bytes = static_cast<std::uint64_t>(r.ru_maxrss) * 1024;
  }
  use.rss_bytes = beyond_posix::resident_bytes();
  return use;
}

}  // namespace sinew::hal
