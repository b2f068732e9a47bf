#include "hal/linux/process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "hal/linux/beyond_posix.hpp"
#include "hal/linux/pipe.hpp"
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

// The pipes of a child that read_output() reads.
struct Pipes {
  Pipe output, errors;
  bool open(const ChildOptions& options) { return !options.piped || (output.open() && errors.open()); }
};

// In the child, between fork and exec: only calls that are safe there.
void settle(const ChildOptions& options, const Pipes& pipes, pid_t parent) {
  beyond_posix::end_with_parent(options.killed_when_we_die ? SIGKILL : SIGTERM);
  if (getppid() != parent) _exit(127);
  if (options.own_group) setpgid(0, 0);
  if (!options.hears_terminal) signal(SIGINT, SIG_IGN);
  if (options.piped) {
    dup2(pipes.output.write, STDOUT_FILENO);
    dup2(pipes.errors.write, STDERR_FILENO);
    const int nothing = open("/dev/null", O_RDONLY | O_CLOEXEC);
    if (nothing >= 0) dup2(nothing, STDIN_FILENO);
  } else if (!options.log_path.empty()) {
    const int fd = open(options.log_path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (fd >= 0) {
      dup2(fd, STDOUT_FILENO);
      dup2(fd, STDERR_FILENO);
    }
  }
}

[[noreturn]] void become(const std::vector<char*>& argv, int report_fd) {
  execv(argv[0], argv.data());
  const int error = errno;
  [[maybe_unused]] const auto n = write(report_fd, &error, sizeof(error));
  _exit(127);
}

constexpr Duration kWithoutReport = std::chrono::milliseconds(3);  // between looks where the kernel reports no ends

/// poll()'s milliseconds, not less than `patience`.
int poll_ms(Duration patience) {
  const Duration whole =
      std::min<Duration>(patience, std::chrono::hours(1)) + std::chrono::milliseconds(1) - Duration(1);
  return std::max(0, static_cast<int>(whole / std::chrono::milliseconds(1)));
}

/// False: nothing for now, or nothing any more; then the end is closed.
bool read_some(int& end, std::string& to) {
  if (end < 0) return false;
  char buffer[64 << 10];
  const ssize_t n = ::read(end, buffer, sizeof buffer);
  if (n > 0) to.append(buffer, static_cast<std::size_t>(n));
  if (n == 0 || (n < 0 && errno != EAGAIN && errno != EINTR)) Pipe::close(end);
  return n > 0;
}

}  // namespace

Result<std::unique_ptr<ChildProcess>> ChildProcess::start(const std::vector<std::string>& argv,
                                                          const ChildOptions& options) {
  hear_of_children();
  std::vector<char*> raw;
  for (const auto& a : argv) raw.push_back(const_cast<char*>(a.c_str()));
  raw.push_back(nullptr);
  Pipe report;  // closed by a successful exec; otherwise carries its errno
  Pipes pipes;
  if (!report.open() || !pipes.open(options)) return Error{Errc::io, "pipe2", errno};
  const pid_t parent = getpid();
  const pid_t pid = ::fork();
  if (pid == 0) {
    settle(options, pipes, parent);
    become(raw, report.write);
  }
  if (pid < 0) return Error{Errc::io, "fork", errno};
  Pipe::close(report.write);
  int error = 0;
  ssize_t got = 0;
  do got = read(report.read, &error, sizeof(error));
  while (got < 0 && errno == EINTR);
  if (got == sizeof(error)) {
    while (waitpid(pid, nullptr, 0) < 0 && errno == EINTR) {
    }
    return Error{error == ENOENT ? Errc::not_found : Errc::io, "exec", error};
  }
  std::unique_ptr<ChildProcess> child(new ChildProcess(pid));
  child->watch(options, pipes.output, pipes.errors);
  return child;
}

Result<std::unique_ptr<ChildProcess>> ChildProcess::fork(const std::function<int()>& body) {
  return copy(body, nullptr);
}

Result<std::unique_ptr<ChildProcess>> ChildProcess::fork(const std::function<int()>& body,
                                                         const ChildOptions& options) {
  return copy(body, &options);
}

Result<std::unique_ptr<ChildProcess>> ChildProcess::copy(const std::function<int()>& body,
                                                         const ChildOptions* options) {
  std::size_t threads = beyond_posix::threads();
  for (int ms = 0; threads > 1 && ms < 50; ++ms) {  // one that was joined is still counted for a moment
    system_os().sleep_until(system_os().now() + std::chrono::milliseconds(1));
    threads = beyond_posix::threads();
  }
  if (threads > 1) return Error{Errc::not_supported, "fork with more than one thread", std::int64_t(threads)};
  hear_of_children();
  std::fflush(nullptr);  // otherwise both would write the buffered bytes
  Pipes pipes;
  if (options && !pipes.open(*options)) return Error{Errc::io, "pipe2", errno};
  const pid_t parent = getpid();
  const pid_t pid = ::fork();
  if (pid < 0) return Error{Errc::io, "fork", errno};
  if (pid == 0) {
    if (options) {
      std::signal(SIGTERM, SIG_DFL);
      std::signal(SIGINT, SIG_DFL);
      settle(*options, pipes, parent);
      for (Pipe* pipe : {&pipes.output, &pipes.errors}) Pipe::close(pipe->read), Pipe::close(pipe->write);
    }
    std::exit(body());
  }
  std::unique_ptr<ChildProcess> child(new ChildProcess(pid));
  if (options) {
    if (options->own_group) setpgid(pid, pid);  // the copy does so, too: it is done, whoever comes first
    child->watch(*options, pipes.output, pipes.errors);
  }
  return child;
}

void ChildProcess::watch(const ChildOptions& options, Pipe& output, Pipe& errors) {
  own_group_ = options.own_group;
  if (!options.piped) return;
  for (const Pipe* pipe : {&output, &errors}) fcntl(pipe->read, F_SETFL, O_NONBLOCK);
  output_ = std::exchange(output.read, -1);
  errors_ = std::exchange(errors.read, -1);
  end_ = beyond_posix::end_of_child(pid_);
}

bool ChildProcess::read_output(std::string& output, std::string& errors) {
  const bool more = read_some(output_, output);
  return read_some(errors_, errors) || more;
}

// Before the child is reaped: until then no other group can have its number.
void ChildProcess::end_group() {
  siginfo_t info{};
  if (waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOHANG | WNOWAIT) == 0 && info.si_pid == pid_)
    kill(-pid_, SIGKILL);
}

std::optional<int> ChildProcess::poll() {
  int status = 0;
  if (own_group_ && !exit_code_) end_group();
  while (!exit_code_ && waitpid(pid_, &status, WNOHANG | WUNTRACED | WCONTINUED) == pid_) {
    stopped_ = WIFSTOPPED(status);
    if (WIFSTOPPED(status) || WIFCONTINUED(status)) continue;
    exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  return exit_code_;
}

void ChildProcess::wait_for_any(std::span<ChildProcess* const> children, Duration patience,
                                std::vector<std::size_t>& ready) {
  std::vector<pollfd> fds;
  fds.reserve(3 * children.size());
  bool all_report = true;
  for (const ChildProcess* child : children) {
    for (const int end : {child->output_, child->errors_, child->end_}) fds.push_back({end, POLLIN, 0});
    all_report = all_report && child->end_ >= 0;
  }
  // poll() leaves out negative descriptors.
  ::poll(fds.data(), static_cast<nfds_t>(fds.size()),
         poll_ms(all_report ? patience : std::min(patience, kWithoutReport)));
  ready.clear();
  for (std::size_t i = 0; i < children.size(); ++i) {
    const bool news = fds[3 * i].revents != 0 || fds[3 * i + 1].revents != 0 || fds[3 * i + 2].revents != 0;
    if (news || children[i]->end_ < 0) ready.push_back(i);
  }
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
  if (!poll()) kill(own_group_ ? -pid_ : pid_, SIGKILL);
}

ChildProcess::~ChildProcess() {
  terminate();
  if (!wait(std::chrono::seconds(2))) {
    kill_now();
    wait(std::chrono::seconds(2));
  }
  for (int* end : {&output_, &errors_, &end_}) Pipe::close(*end);
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

std::size_t most_open_files() {
  const long most = sysconf(_SC_OPEN_MAX);
  return most > 0 ? static_cast<std::size_t>(most) : SIZE_MAX;
}

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
