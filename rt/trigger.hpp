#pragma once
// What releases a thread that waits for topics or a device: a word to sleep on that counts triggers.
#include <atomic>

#include "hal/device.hpp"
#include "hal/os.hpp"
#include "rt/step.hpp"

namespace sinew::rt {

/// Counts triggers in the upper 31 bits of a word; bit 0 says that the owner sleeps, so that the kernel is entered only
/// then. The owner is one thread, triggers come from any.
class Trigger final : public hal::Wake {
 public:
  explicit Trigger(hal::Os& os) : os_(os) {}

  /// Thread: any.   RT: yes.
  void fire(Time now) noexcept {
    if (word_.load(std::memory_order_relaxed) >> 1 == taken_.load(std::memory_order_relaxed))
      at_.store(now.ns, std::memory_order_relaxed);  // the first of those that will be taken together
    // release: partner is wait(); whoever sees the count sees the commit behind it (which has its own order) and at_.
    if (word_.fetch_add(2, std::memory_order_release) & 1) os_.wake(word_);
  }
  void wake() noexcept override { fire(os_.now()); }

  // ---- the owner's side
  /// Triggers not yet taken.
  std::uint32_t waiting() const noexcept {
    return ((word_.load(std::memory_order_acquire) >> 1) - taken_.load(std::memory_order_relaxed)) & kCountMask;
  }
  /// Takes all triggers that wait; answers how many.
  std::uint32_t take() noexcept {
    const std::uint32_t n = waiting();
    taken_.store((taken_.load(std::memory_order_relaxed) + n) & kCountMask, std::memory_order_relaxed);
    return n;
  }
  /// Instant of the first trigger that waits; while waiting() > 0.
  Time at() const noexcept { return {at_.load(std::memory_order_relaxed)}; }
  /// Sleeps until a trigger waits or the deadline has passed. False: the deadline.
  bool wait(Time deadline) noexcept {
    while (waiting() == 0) {
      if (deadline != hal::kNever && os_.now() >= deadline) return false;
      std::uint32_t seen = word_.load(std::memory_order_acquire);
      if (seen >> 1 != taken_.load(std::memory_order_relaxed)) continue;
      if (!word_.compare_exchange_strong(seen, seen | 1, std::memory_order_acquire)) continue;
      os_.wait(word_, seen | 1, deadline);
      word_.fetch_and(~std::uint32_t{1}, std::memory_order_acquire);
    }
    return true;
  }

 private:
  static constexpr std::uint32_t kCountMask = 0x7FFFFFFF;
  hal::Os& os_;
  hal::WakeWord word_{0};
  std::atomic<std::uint32_t> taken_{0};  // written by the owner; others only guess with it
  std::atomic<std::int64_t> at_{0};      // private memory, so 64 bits are fine
};

}  // namespace sinew::rt
