#pragma once
#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "hal/os.hpp"
#include "hal/wake_slot.hpp"

namespace sinew::hal {

/// One descriptor under watch: whether something has come since its device was last found empty, and who wants to know.
/// The device's read() says begin_read() before it looks; when it finds nothing, the line stays quiet until more comes.
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
  std::atomic<bool> ready_{true};  // nobody has looked yet
  WakeSlot wake_;
};

/// One thread that sleeps on many descriptors and rings whoever waits for one: what an interrupt is to devices that are
/// files. Edge-triggered: read until nothing is left.
/// Thread:  any but for the destructor.   RT: no.
class FdWatch {
 public:
  /// `priority`: SCHED_FIFO, as that of an interrupt thread: above the modules that wait for it.
  static Result<std::shared_ptr<FdWatch>> start(Os& os, const ThreadOptions& options);
  /// One without a thread, which rings nobody: for who looks by himself.
  static std::shared_ptr<FdWatch> none() { return std::shared_ptr<FdWatch>(new FdWatch(-1, -1)); }
  ~FdWatch();
  /// Rings `line` whenever `fd` has more to read, hangs up or fails. The fd stays the caller's. Errors: io.
  Status add(int fd, FdLine& line);
  /// When this returns, the line is not touched any more. Before the fd is closed.
  void remove(int fd) noexcept;
  /// What its thread could not have; see Thread::shortfall().
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
