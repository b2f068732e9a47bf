#pragma once
// The runtime's needs from an operating system, in robot terms; hal/linux implements it.
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "hal/clock.hpp"
#include "hal/result.hpp"

namespace sinew::hal {

/// The word a thread sleeps on. Private memory; 32 bits everywhere (futex, WaitOnAddress).
using WakeWord = std::atomic<std::uint32_t>;

struct ThreadOptions {
  std::string name;                      // at most 15 characters are shown by the kernel
  int fifo_priority = 0;                 // SCHED_FIFO 1..99; 0 = ordinary
  std::vector<int> cpus;                 // empty: any
  std::size_t stack_bytes = 256 * 1024;  // prefaulted where fifo_priority > 0
  int nice = 0;                          // ordinary priority: 1..19 lower, -20..-1 higher (where permitted)
};

class Thread {
 public:
  virtual ~Thread() = default;  // joins
  virtual void join() = 0;
  /// What was refused (privilege, CPU); empty when everything was granted. The thread runs all the same.
  virtual const std::string& shortfall() const = 0;
};

/// Zeroed, page-aligned, locked where permitted memory that other processes may be given later; or a peer's.
class SharedMemory {
 public:
  virtual ~SharedMemory() = default;
  /// Null: a peer's memory that is only copied from.
  virtual std::byte* data() = 0;
  virtual std::size_t size() const = 0;
  /// Copies its content at `offset`. False: the memory does not reach that far. RT: yes.
  virtual bool copy(std::size_t offset, std::span<std::byte> into) const noexcept = 0;
  /// Wakes all that sleep on a word of this memory, in any process. Nothing happens for memory that cannot be handed
  /// on. RT: yes, one system call.
  virtual void wake_all(WakeWord&) noexcept {}
  /// The handle for Stream::write_with_memory(); negative: memory that cannot be handed on.
  virtual std::intptr_t handle() const { return -1; }
};

class Os : public Clock {
 public:
  /// How fast this clock advances beside the clocks of the system.
  virtual double rate() const noexcept { return 1; }
  /// Sleeps until an absolute time of this clock. RT: this is the wait.
  virtual void sleep_until(Time t) noexcept = 0;
  /// Sleeps while `word` holds `expected`, at most until `deadline` (kNever: no limit). Returns at once when it
  /// differs. May return early without reason; callers look again.
  virtual void wait(WakeWord& word, std::uint32_t expected, Time deadline) noexcept = 0;
  /// Wakes the sleepers on `word`; call only when there are any.
  virtual void wake(WakeWord& word) noexcept = 0;
  /// Processor time used by the calling thread.
  virtual Duration thread_cpu_time() noexcept = 0;
  virtual Result<std::unique_ptr<Thread>> start_thread(const ThreadOptions& options, std::function<void()> body) = 0;
  virtual Result<std::unique_ptr<SharedMemory>> shared_memory(std::string_view name, std::size_t bytes) = 0;
  /// Locks all memory of the process, now and later. Errors: denied.
  virtual Status lock_memory() = 0;
  /// Keeps processors out of idle states that they wake from slowly, until the returned object is destroyed.
  /// Errors:  denied; not_found where the system has no such means, which need not matter.
  virtual Result<std::shared_ptr<void>> keep_awake() { return Error{Errc::not_found, "keep_awake"}; }
};

}  // namespace sinew::hal
