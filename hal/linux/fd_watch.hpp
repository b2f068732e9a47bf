#pragma once
#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "hal/os.hpp"
#include "hal/wake_slot.hpp"

namespace sinew::hal {

/// One watched descriptor: records whether data came since its device was last found empty, and whom to wake. The
/// device's read() calls begin_read() before it looks; after an empty read, the line is not ready until more comes.
/// Thread:  ring(): the watch's; the others: the device's.   RT: all but change_wake().
class FdLine {
 public:
  void ring() noexcept {
    ready_.store(true, std::memory_order_release);
    wake_.ring();
  }
  bool ready() const noexcept { return ready_.load(std::memory_order_acquire); }
  void begin_read() noexcept { ready_.exchange(false, std::memory_order_acq_rel); }
  /// More may be there than was read.
  void keep_ready() noexcept { ready_.store(true, std::memory_order_release); }
  void change_wake(Wake* wake) noexcept { wake_.change(wake); }

 private:
  std::atomic<bool> ready_{true};  // not read yet
  WakeSlot wake_;
};

/// One thread that sleeps on many descriptors and wakes the device of each: it replaces interrupts for devices that are
/// files. Edge-triggered: read until nothing is left.
/// Thread:  any, except the destructor.   RT: no.
class FdWatch {
 public:
  /// `priority`: SCHED_FIFO, as of an interrupt thread: above the modules that wait for it.
  static Result<std::shared_ptr<FdWatch>> start(Os& os, const ThreadOptions& options);
  /// A watch without a thread that rings no line: for callers that poll.
  static std::shared_ptr<FdWatch> none() { return std::shared_ptr<FdWatch>(new FdWatch(-1, -1)); }
  ~FdWatch();
  /// Rings `line` whenever `fd` has more to read, hangs up or fails. The fd stays the caller's. Errors: io.
  Status add(int fd, FdLine& line);
  /// When this returns, the line is not touched any more. Call before the fd is closed.
  void remove(int fd) noexcept;
  /// What its thread was refused; see Thread::shortfall().
  std::string shortfall() const { return thread_ ? thread_->shortfall() : std::string(); }

 private:
  FdWatch(int epoll, int stop);
  void loop() noexcept;

  struct Entry {
    int fd;
    FdLine* line;
  };
  int epoll_, stop_;
  std::mutex mutex_;  // the watch's own thread and configuration; a device's read() never takes it
  std::vector<Entry> entries_;
  std::unique_ptr<Thread> thread_;
};

}  // namespace sinew::hal
