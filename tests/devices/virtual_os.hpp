#pragma once
// An operating system whose threads run one at a time, in virtual time: the drivers' own threads run unchanged, and
// each run is the same.
#include <poll.h>

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "hal/os.hpp"

namespace sinew::test {

/// Time moves only in run_until() and when its caller sleeps. A thread runs until it sleeps, waits or ends; the caller
/// that wakes it goes on first. One thread runs at a time; sim_kernel leads the kernel's ppoll() and clock_gettime()
/// here.
/// Thread:  run_until() and all that a board does: the test's.
class VirtualOs final : public hal::Os {
 public:
  VirtualOs();
  ~VirtualOs() override;

  /// Lets threads run, in the order of their instants, until nothing is left to do by `t`.
  void run_until(hal::Time t);

  hal::Time now() const noexcept override { return clock.now(); }
  void sleep_until(hal::Time t) noexcept override;
  void wait(hal::WakeWord& word, std::uint32_t expected, hal::Time deadline) noexcept override;
  void wake(hal::WakeWord& word) noexcept override;
  hal::Duration thread_cpu_time() noexcept override { return {}; }
  hal::Result<std::unique_ptr<hal::Thread>> start_thread(const hal::ThreadOptions& options,
                                                         std::function<void()> body) override;
  hal::Result<std::unique_ptr<hal::SharedMemory>> shared_memory(std::string_view, std::size_t) override {
    return hal::Error{hal::Errc::not_supported, "no memory here"};
  }
  hal::Status lock_memory() override { return {}; }

  /// ppoll() of one of its threads. Nothing: the caller is another thread.
  std::optional<int> poll(pollfd* fds, nfds_t count, hal::Time deadline) noexcept;
  /// The instance that lives now; null: none.
  static VirtualOs* current() noexcept;

  hal::ManualClock clock;  // the executor's, too

 private:
  struct Task {
    std::function<void()> body;
    std::thread thread;
    bool runs = false, ended = false;
    hal::Time due{};
    const hal::WakeWord* word = nullptr;
    pollfd* fds = nullptr;
    nfds_t fd_count = 0;
  };
  class Handle;
  void block(Task& task);
  void hand_over(Task& task);
  void join(Task& task);
  Task* next_due(hal::Time t);
  static Task*& mine() noexcept;

  std::mutex mutex_;
  std::condition_variable moved_;
  std::vector<std::unique_ptr<Task>> tasks_;
};

}  // namespace sinew::test
