// The processor time that the kernel alone takes for the quadrotor's threads: bare threads that make the same calls at
// the same rates as a flight with simulated sensors, and compute nothing. A child of this program plays the simulator.
// Usage: processor_floor [seconds]. Prints percent of a core.
#include <linux/futex.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <climits>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "hal/platform.hpp"

namespace sinew::bench {
namespace {

constexpr std::int64_t kNsPerS = 1'000'000'000, kNsPerMs = 1'000'000;
constexpr int kSampleBytes = 120, kCommandBytes = 112;  // an IMU sample, motor commands

std::int64_t now_ns() {
  timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return std::int64_t{t.tv_sec} * kNsPerS + t.tv_nsec;
}

void sleep_until(std::int64_t ns) {
  const timespec t{ns / kNsPerS, ns % kNsPerS};
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr);
}

/// A thread waits in wait() until another calls wake().
class Trigger {
 public:
  void wait(std::int64_t until_ns) {
    const int seen = count_.load();
    const timespec t{until_ns / kNsPerS, until_ns % kNsPerS};
    syscall(SYS_futex, &count_, FUTEX_WAIT_BITSET_PRIVATE, seen, &t, nullptr, FUTEX_BITSET_MATCH_ANY);
  }
  void wake() {
    count_.fetch_add(1);
    syscall(SYS_futex, &count_, FUTEX_WAKE_PRIVATE, INT_MAX, nullptr, nullptr, 0);
  }

 private:
  std::atomic<int> count_{0};
};

/// Sends a sample each millisecond and drops what it gets.
[[noreturn]] void simulate(int link, std::int64_t end) {
  char bytes[4096] = {};
  for (std::int64_t next = now_ns(); next < end; next += kNsPerMs) {
    sleep_until(next);
    if (::send(link, bytes, kSampleBytes, MSG_NOSIGNAL) < 0) break;
    while (::recv(link, bytes, sizeof(bytes), MSG_DONTWAIT) > 0) {
    }
  }
  std::_Exit(0);
}

int run(double seconds) {
  mlockall(MCL_CURRENT | MCL_FUTURE);
  int link[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM, 0, link) != 0) return 2;
  const std::int64_t begin = now_ns() + 100 * kNsPerMs;
  const std::int64_t end = begin + static_cast<std::int64_t>(seconds * static_cast<double>(kNsPerS));
  const pid_t child = ::fork();
  if (child < 0) return 2;
  if (child == 0) simulate(link[1], end);

  Trigger guardian;
  std::vector<std::unique_ptr<hal::Thread>> threads;
  const auto start = [&](const char* name, int priority, auto loop) {
    hal::ThreadOptions options;
    options.name = name;
    options.fifo_priority = priority;
    auto thread = hal::system_os().start_thread(options, loop);
    if (!thread) std::exit(2);
    threads.push_back(std::move(*thread));
  };
  const auto periodic = [&](std::int64_t period, auto each) {
    return [=] {
      for (std::int64_t next = begin; next < end; next += period) {
        sleep_until(next);
        each();
      }
    };
  };
  start("guardian", 98, [&] {
    const char command[kCommandBytes] = {};
    while (now_ns() < end) {
      guardian.wait(now_ns() + 10 * kNsPerMs);
      ::send(link[0], command, sizeof(command), MSG_DONTWAIT | MSG_NOSIGNAL);
    }
  });
  start("reader", 95, [&] {
    char bytes[4096];
    while (now_ns() < end) {
      pollfd ready{link[0], POLLIN, 0};
      const timespec limit{0, 100 * kNsPerMs};
      if (::ppoll(&ready, 1, &limit, nullptr) > 0 && ::recv(link[0], bytes, sizeof(bytes), MSG_DONTWAIT) == 0) break;
    }
  });
  start("stabilise", 80, periodic(kNsPerMs, [&] { guardian.wake(); }));
  start("navigate", 70, periodic(5 * kNsPerMs, [] {}));
  start("ranging", 60, periodic(10 * kNsPerMs, [] {}));
  start("vision", 40, periodic(33 * kNsPerMs, [] {}));
  sleep_until(begin);
  rusage before{}, after{};
  getrusage(RUSAGE_SELF, &before);
  sleep_until(end);
  getrusage(RUSAGE_SELF, &after);
  threads.clear();
  ::waitpid(child, nullptr, 0);
  const auto s = [](const timeval& t) { return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_usec) * 1e-6; };
  const double used = s(after.ru_utime) + s(after.ru_stime) - s(before.ru_utime) - s(before.ru_stime);
  std::printf("%.1f\n", 100 * used / seconds);
  return 0;
}

}  // namespace
}  // namespace sinew::bench

int main(int argc, char** argv) { return sinew::bench::run(argc > 1 ? std::atof(argv[1]) : 5); }
