#include "apps/net/supervisor.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <memory>
#include <optional>

#include "apps/command/command.hpp"
#include "hal/linux/process.hpp"
#include "hal/platform.hpp"

namespace sinew::app {
namespace {

using namespace std::chrono_literals;

constexpr hal::Duration kLook = 100ms;  // seldom: ChildProcess::wait() looks 500 times a second
constexpr int kToBegin = 4;             // times the patience: a slow board takes seconds to start a program

/// What workers write to by beat(). They inherit the end for writing.
class Beats {
 public:
  Beats() {
    if (pipe2(ends_.data(), O_NONBLOCK) != 0) ends_ = {-1, -1};
    if (ends_[0] >= 0) fcntl(ends_[0], F_SETFD, FD_CLOEXEC);
  }
  ~Beats() {
    for (const int end : ends_)
      if (end >= 0) close(end);
  }
  Beats(const Beats&) = delete;
  Beats& operator=(const Beats&) = delete;
  bool ok() const { return ends_[0] >= 0; }
  int for_worker() const { return ends_[1]; }
  /// Any since the last call.
  bool take() {
    std::array<char, 64> bytes;
    bool any = false;
    while (read(ends_[0], bytes.data(), bytes.size()) > 0) any = true;
    return any;
  }

 private:
  std::array<int, 2> ends_{-1, -1};
};

/// Its exit code; nothing: a signal asks us to end. Kills it when it hangs, as Cyclone may do, or when it was stopped.
std::optional<int> watch(hal::ChildProcess& worker, Beats& beats, hal::Duration patience) {
  hal::Os& os = hal::system_os();
  hal::Duration silent{};  // by our looks: while we do not run either, it is not silent
  bool began = false;
  for (;;) {
    if (const auto code = worker.poll()) return code;
    if (hal::stop_requested()) return std::nullopt;
    os.sleep_until(os.now() + kLook);
    if (beats.take()) began = true, silent = {};
    silent += kLook;
    if (silent < (began ? patience : kToBegin * patience)) continue;
    std::fprintf(stderr, "sinew-net: DDS hangs: nothing of process %d for %lld s, so it is killed\n", worker.pid(),
                 static_cast<long long>(silent / 1s));
    worker.kill_now();
    silent = {};
  }
}

}  // namespace

void beat(int fd) {
  const char one = 1;
  static_cast<void>(write(fd, &one, 1) < 0);  // full: nobody looks, or has still to look at those before
}

int supervise_net(const std::string& program, const std::string& file, hal::Duration patience) {
  hal::Os& os = hal::system_os();
  Beats beats;
  if (!beats.ok()) return fail(std::string("a pipe: ") + std::strerror(errno));
  int attempt = 0, accidents = 0;
  while (!hal::stop_requested()) {
    hal::ChildOptions options;
    options.hears_terminal = false;  // we end it
    options.killed_when_we_die = true;
    auto worker = hal::ChildProcess::start(
        {program, "--worker", "--attempt", std::to_string(attempt), "--beat", std::to_string(beats.for_worker()), file},
        options);
    if (!worker) return fail(program + ": " + hal::to_string(worker.error().code));
    const hal::Time begin = os.now();
    const auto code = watch(**worker, beats, patience);
    if (!code) {
      (*worker)->terminate();
      // After a changed address Cyclone may not end by itself.
      if (!(*worker)->wait(2s)) (*worker)->kill_now();
      break;
    }
    if (*code == kDone || *code == kNotBegun) return *code;
    attempt = *code == kNetFailed ? std::min(attempt + 1, 30) : 0;
    if (*code == kNetAnew || *code == kNetFailed) {
      accidents = 0;
      continue;
    }
    if (os.now() - begin > 10s) accidents = 0;
    const hal::Duration pause = std::min<hal::Duration>(200ms * (1 << std::min(accidents++, 10)), 10s);
    std::fprintf(stderr, "sinew-net: %s; started again in %lld ms\n", hal::describe_exit(*code).c_str(),
                 static_cast<long long>(pause / 1ms));
    for (const hal::Time until = os.now() + pause; os.now() < until && !hal::stop_requested();)
      os.sleep_until(std::min(until, os.now() + kLook));
  }
  return kDone;
}

}  // namespace sinew::app
