#include "hal/platform.hpp"

#include <alloca.h>
#include <fcntl.h>
#include <malloc.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cstring>
#include <ctime>

#include "hal/linux/futex.hpp"
#include "hal/linux/memory.hpp"
#include "hal/linux/shared_memory.hpp"

namespace sinew::hal {
namespace {

constexpr std::int64_t kNsPerSecond = 1'000'000'000;

static_assert(sizeof(time_t) == 8, "times have 64 bits on every machine: _TIME_BITS=64 (cmake/compiler.cmake)");

timespec to_timespec(Time t) {
  timespec ts;
  ts.tv_sec = static_cast<time_t>(t.ns / kNsPerSecond);
  ts.tv_nsec = static_cast<long>(t.ns % kNsPerSecond);
  return ts;
}

Time read_clock(clockid_t id) {
  timespec ts;
  clock_gettime(id, &ts);
  return {std::int64_t{ts.tv_sec} * kNsPerSecond + ts.tv_nsec};
}

// A thread's stack needs room besides what the robot file asks for: thread-local data of the C library and of programs.
// The thread sanitizer adds hundreds of kilobytes.
#ifdef __SANITIZE_THREAD__
constexpr std::size_t kOwnStackUse = 2 * 1024 * 1024;
#else
constexpr std::size_t kOwnStackUse = 64 * 1024;
#endif

// Touches the stack once so that no page fault comes later; kept out of line so that the pages are really below us.
[[gnu::noinline]] void prefault_stack(std::size_t bytes) {
  auto* page = static_cast<volatile char*>(alloca(bytes));
  for (std::size_t i = 0; i < bytes; i += 4096) page[i] = 0;
}

/// A stack between two guard pages: the one below catches an overflow, the one above keeps the mapping apart from
/// others, so that lock_process_memory() recognises it.
class Stack {
 public:
  Stack() = default;
  ~Stack() {
    if (size_ > 0) munmap(lowest_ - kGuard, size_ + 2 * kGuard);
  }
  Stack(const Stack&) = delete;
  Stack& operator=(const Stack&) = delete;

  bool make(std::size_t bytes) {
    bytes = std::max((bytes + kGuard - 1) / kGuard * kGuard, static_cast<std::size_t>(PTHREAD_STACK_MIN));
    void* all = mmap(nullptr, bytes + 2 * kGuard, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_STACK, -1, 0);
    if (all == MAP_FAILED) return false;
    lowest_ = static_cast<char*>(all) + kGuard;
    size_ = bytes;
    return mprotect(lowest_, size_, PROT_READ | PROT_WRITE) == 0;
  }
  void* lowest() const { return lowest_; }
  std::size_t size() const { return size_; }

 private:
  static constexpr std::size_t kGuard = 64 * 1024;  // a multiple of every page size
  char* lowest_ = nullptr;
  std::size_t size_ = 0;
};

class LinuxThread final : public Thread {
 public:
  LinuxThread(const ThreadOptions& options, std::function<void()> body) : options_(options), body_(std::move(body)) {}
  ~LinuxThread() override { LinuxThread::join(); }

  Status start() {
    if (!stack_.make(options_.stack_bytes + kOwnStackUse)) return Error{Errc::out_of_memory, "stack", errno};
    pthread_attr_t attr;
    pthread_attr_init(&attr);
    pthread_attr_setstack(&attr, stack_.lowest(), stack_.size());
    const int error = pthread_create(&thread_, &attr, &LinuxThread::entry, this);
    pthread_attr_destroy(&attr);
    if (error != 0) return Error{Errc::io, "pthread_create", error};
    joinable_ = true;
    while (set_up_.load(std::memory_order_acquire) == 0)  // so that shortfall() is complete when start returns
      futex_wait(set_up_, 0, kNever, FutexScope::process);
    return {};
  }

  void join() override {
    if (joinable_) pthread_join(thread_, nullptr);
    joinable_ = false;
  }
  const std::string& shortfall() const override { return shortfall_; }

 private:
  static void* entry(void* self) {
    auto& t = *static_cast<LinuxThread*>(self);
    t.set_up();
    t.set_up_.store(1, std::memory_order_release);
    futex_wake(t.set_up_, INT_MAX, FutexScope::process);
    t.body_();
    return nullptr;
  }

  void set_up() {
    pthread_setname_np(pthread_self(), options_.name.substr(0, 15).c_str());
    if (!options_.cpus.empty()) {
      cpu_set_t set;
      CPU_ZERO(&set);
      for (int cpu : options_.cpus)
        if (cpu >= 0 && cpu < CPU_SETSIZE) CPU_SET(static_cast<unsigned>(cpu), &set);
      if (const int e = pthread_setaffinity_np(pthread_self(), sizeof(set), &set); e != 0) fall_short("CPU set", e);
    }
    if (options_.fifo_priority > 0) {
      sched_param p{};
      p.sched_priority = options_.fifo_priority;
      if (const int e = pthread_setschedparam(pthread_self(), SCHED_FIFO, &p); e != 0) fall_short("SCHED_FIFO", e);
    }
    // For ordinary priority, whose wake-ups are otherwise up to 50 us late on purpose; SCHED_FIFO has no slack. Never
    // refused.
    prctl(PR_SET_TIMERSLACK, 1UL);
    if (options_.nice != 0) setpriority(PRIO_PROCESS, 0, options_.nice);  // of this thread; it also runs if refused
    if (options_.fifo_priority > 0) prefault_stack(options_.stack_bytes);
  }

  void fall_short(const char* what, int error) {
    if (!shortfall_.empty()) shortfall_ += "; ";
    shortfall_ += std::string(what) + " refused: " + std::strerror(error);
  }

  Stack stack_;
  ThreadOptions options_;
  std::function<void()> body_;
  std::string shortfall_;
  pthread_t thread_{};
  bool joinable_ = false;
  WakeWord set_up_{0};
};

class LinuxOs final : public Os {
 public:
  // One heap for all threads: otherwise each thread would reserve, and once locked keep, its own heap for its
  // allocations at start.
  LinuxOs() { mallopt(M_ARENA_MAX, 1); }

  Time now() const noexcept override { return read_clock(CLOCK_MONOTONIC); }

  void sleep_until(Time t) noexcept override {
    const timespec ts = to_timespec(t);
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &ts, nullptr) == EINTR) {
    }
  }

  void wait(WakeWord& word, std::uint32_t expected, Time deadline) noexcept override {
    futex_wait(word, expected, deadline, FutexScope::process);
  }

  void wake(WakeWord& word) noexcept override { futex_wake(word, 1, FutexScope::process); }

  Duration thread_cpu_time() noexcept override { return Duration{read_clock(CLOCK_THREAD_CPUTIME_ID).ns}; }

  Result<std::unique_ptr<Thread>> start_thread(const ThreadOptions& options, std::function<void()> body) override {
    auto thread = std::make_unique<LinuxThread>(options, std::move(body));
    if (auto status = thread->start(); !status) return status.error();
    return std::unique_ptr<Thread>(std::move(thread));
  }

  Result<std::unique_ptr<SharedMemory>> shared_memory(std::string_view name, std::size_t bytes) override {
    return create_shared_memory(name, bytes);
  }

  Status lock_memory() override { return lock_process_memory(); }

  // The request holds while the file is open. Source: Documentation/power/pm_qos_interface.rst of Linux
  Result<std::shared_ptr<void>> keep_awake() override {
    const int fd = ::open("/dev/cpu_dma_latency", O_WRONLY | O_CLOEXEC);
    if (fd < 0) return Error{errno == ENOENT ? Errc::not_found : Errc::denied, "/dev/cpu_dma_latency", errno};
    const auto close_file = [](void* p) {
      ::close(*static_cast<int*>(p));
      delete static_cast<int*>(p);
    };
    std::shared_ptr<void> held(new int(fd), close_file);
    const std::int32_t latency_us = 0;
    if (::write(fd, &latency_us, sizeof(latency_us)) != sizeof(latency_us))
      return Error{Errc::io, "/dev/cpu_dma_latency", errno};
    return held;
  }
};

}  // namespace

Os& system_os() {
  static LinuxOs os;
  return os;
}

}  // namespace sinew::hal
