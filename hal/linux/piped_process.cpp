#include "hal/linux/piped_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>

#include "hal/linux/beyond_posix.hpp"
#include "hal/linux/pipe.hpp"

namespace sinew::hal {
namespace {

/// Makes a write to a program that no longer reads an error instead of the end of this process.
class NoBrokenPipe {
 public:
  NoBrokenPipe() {
    struct sigaction ignore {};
    ignore.sa_handler = SIG_IGN;
    sigaction(SIGPIPE, &ignore, &before_);
  }
  ~NoBrokenPipe() { sigaction(SIGPIPE, &before_, nullptr); }
  NoBrokenPipe(const NoBrokenPipe&) = delete;
  NoBrokenPipe& operator=(const NoBrokenPipe&) = delete;

 private:
  struct sigaction before_ {};
};

// Between fork and exec: only calls that are safe there.
[[noreturn]] void become_piped(const std::vector<char*>& argv, int in, int out, int err, int report, pid_t parent) {
  beyond_posix::end_with_parent(SIGTERM);
  if (getppid() != parent) _exit(127);
  std::signal(SIGPIPE, SIG_DFL);
  dup2(in, STDIN_FILENO);
  if (out >= 0) dup2(out, STDOUT_FILENO);
  if (err >= 0) dup2(err, STDERR_FILENO);
  execvp(argv[0], argv.data());
  const int error = errno;
  [[maybe_unused]] const auto n = write(report, &error, sizeof error);
  _exit(127);
}

Error not_started(int error) {
  if (error == ENOENT || error == ENOTDIR) return {Errc::not_found, "exec", error};
  if (error == EACCES || error == EPERM) return {Errc::denied, "exec", error};
  return {Errc::io, "exec", error};
}

/// The exit code, as ChildProcess::poll() has it.
int reap(pid_t pid) {
  int status = 0;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) continue;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

class Talk {
 public:
  Talk(const PipedIo& io, Pipe& in, Pipe& out, Pipe& err) : io_(io), in_(in), out_(out), err_(err) {}

  Status run() {
    if (io_.input) fcntl(in_.write, F_SETFL, O_NONBLOCK);
    while (in_.write >= 0 || out_.read >= 0 || err_.read >= 0) {
      // poll() leaves out negative descriptors.
      std::array<pollfd, 3> fds{{{in_.write, POLLOUT, 0}, {out_.read, POLLIN, 0}, {err_.read, POLLIN, 0}}};
      if (::poll(fds.data(), fds.size(), -1) < 0) {
        if (errno == EINTR) continue;
        return Error{Errc::io, "poll", errno};
      }
      if (fds[0].revents != 0) feed();
      if (fds[1].revents != 0) listen(out_.read, io_.output);
      if (fds[2].revents != 0) listen(err_.read, io_.errors);
    }
    return {};
  }

 private:
  void feed() {
    if (piece_.empty()) piece_ = io_.input();
    if (piece_.empty()) return Pipe::close(in_.write);
    const auto n = ::write(in_.write, piece_.data(), piece_.size());
    if (n >= 0) return piece_.remove_prefix(static_cast<std::size_t>(n));
    if (errno != EAGAIN && errno != EINTR) Pipe::close(in_.write);  // the program reads no more
  }
  static void listen(int& end, const std::function<void(std::string_view)>& say) {
    std::array<char, 65536> buffer;
    const auto n = ::read(end, buffer.data(), buffer.size());
    if (n > 0) return say({buffer.data(), static_cast<std::size_t>(n)});
    if (n == 0 || errno != EINTR) Pipe::close(end);
  }

  const PipedIo& io_;
  Pipe &in_, &out_, &err_;
  std::string_view piece_;
};

}  // namespace

Result<int> run_piped(const std::vector<std::string>& argv, const PipedIo& io) {
  std::vector<char*> raw;
  for (const auto& a : argv) raw.push_back(const_cast<char*>(a.c_str()));
  raw.push_back(nullptr);
  std::signal(SIGCHLD, SIG_DFL);  // our parent may have set it to ignore: then no end of a child would be reported
  const NoBrokenPipe guard;
  Pipe in, out, err, report;  // report: closed by a successful exec, else carries its errno
  if (!in.open() || !report.open() || (io.output && !out.open()) || (io.errors && !err.open()))
    return Error{Errc::io, "pipe2", errno};
  const pid_t parent = getpid();
  const pid_t pid = ::fork();
  if (pid == 0) become_piped(raw, in.read, out.write, err.write, report.write, parent);
  if (pid < 0) return Error{Errc::io, "fork", errno};
  for (int* end : {&in.read, &out.write, &err.write, &report.write}) Pipe::close(*end);
  if (!io.input) Pipe::close(in.write);
  int error = 0;
  ssize_t got = 0;
  do got = ::read(report.read, &error, sizeof error);
  while (got < 0 && errno == EINTR);
  if (got == sizeof error) {
    reap(pid);
    return not_started(error);
  }
  if (auto s = Talk(io, in, out, err).run(); !s) {
    ::kill(pid, SIGTERM);
    reap(pid);
    return s.error();
  }
  return reap(pid);
}

}  // namespace sinew::hal
