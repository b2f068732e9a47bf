#pragma once
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace sinew::hal {

/// A bounded queue between the thread that receives and the thread that reads a device; in lockstep both are one
/// thread.
/// Thread:  one producer (push, room, full, next_index), one consumer (all others).
/// RT:      yes after construction.
template <class T>
class SampleRing {
 public:
  explicit SampleRing(std::size_t capacity) : slots_(std::bit_ceil(capacity)) {}

  /// Index of the next push(), for data kept beside the ring; the consumer has finished with it unless the ring is
  /// full.
  std::size_t next_index() const noexcept { return head_.load(std::memory_order_relaxed) & mask(); }
  /// How many push() take at least.
  std::size_t room() const noexcept {
    // acquire: pairs with pop's release, so that the consumer's reading of the slot lies before our writing
    return slots_.size() - (head_.load(std::memory_order_relaxed) - tail_.load(std::memory_order_acquire));
  }
  bool full() const noexcept { return room() == 0; }
  /// False when full; nothing changed then.
  bool push(const T& value) noexcept {
    if (full()) return false;
    const std::uint32_t head = head_.load(std::memory_order_relaxed);
    slots_[head & mask()] = value;
    head_.store(head + 1, std::memory_order_release);  // pairs with size's acquire: the value lies before the count
    return true;
  }

  std::size_t size() const noexcept {
    return head_.load(std::memory_order_acquire) - tail_.load(std::memory_order_relaxed);
  }
  /// The i-th oldest, i < size().
  const T& at(std::size_t i) const noexcept {
    return slots_[(tail_.load(std::memory_order_relaxed) + static_cast<std::uint32_t>(i)) & mask()];
  }
  void pop() noexcept { tail_.store(tail_.load(std::memory_order_relaxed) + 1, std::memory_order_release); }
  std::size_t capacity() const noexcept { return slots_.size(); }

 private:
  std::uint32_t mask() const noexcept { return static_cast<std::uint32_t>(slots_.size() - 1); }
  std::vector<T> slots_;
  alignas(64) std::atomic<std::uint32_t> head_{0};
  alignas(64) std::atomic<std::uint32_t> tail_{0};
};

}  // namespace sinew::hal
