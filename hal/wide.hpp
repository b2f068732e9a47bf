#pragma once
// 64-bit numbers between threads on machines that cannot read 64 bits at once (32-bit MIPS). There the compiler's
// library would take a lock, which a thread of lower priority may hold, and which other processes do not see.
#include <array>
#include <atomic>
#include <bit>
#include <cstdint>
#include <type_traits>

namespace sinew::hal {

inline constexpr bool kReadsWideAtOnce = std::atomic<std::uint64_t>::is_always_lock_free;

/// The number in two copies: the writer fills the copy that readers are not sent to, then sends them to it. So a thread
/// that interrupts the writer reads at once; only a reader that a store interrupts looks again.
/// Thread:  store(): one; load(): any. Writes before a store are visible to a thread that loads it.   RT: yes, without
///          a lock.
template <class T>
class WideInHalves {
  static_assert(sizeof(T) == 8);

 public:
  WideInHalves() noexcept = default;
  explicit WideInHalves(T value) noexcept { store(value); }
  T load(std::memory_order = {}) const noexcept {
    for (;;) {
      const std::uint32_t turn = turn_.load(std::memory_order_acquire);  // store(): this copy is complete
      const Copy& copy = copies_[turn & 1];
      // acquire, with the releases of a later store to this copy: it comes after a turn that is then seen below.
      const std::uint64_t low = copy[0].load(std::memory_order_acquire), high = copy[1].load(std::memory_order_acquire);
      if (turn_.load(std::memory_order_relaxed) == turn) return std::bit_cast<T>(high << 32 | low);
    }
  }
  void store(T value, std::memory_order = {}) noexcept {
    const auto bits = std::bit_cast<std::uint64_t>(value);
    const std::uint32_t turn = turn_.load(std::memory_order_relaxed) + 1;
    Copy& copy = copies_[turn & 1];
    copy[0].store(static_cast<std::uint32_t>(bits), std::memory_order_release);
    copy[1].store(static_cast<std::uint32_t>(bits >> 32), std::memory_order_release);
    turn_.store(turn, std::memory_order_release);
  }

 private:
  using Copy = std::array<std::atomic<std::uint32_t>, 2>;
  std::array<Copy, 2> copies_{};
  std::atomic<std::uint32_t> turn_{0};
};

/// A 64-bit number that one thread stores and any load, without a lock on every machine. In private memory only.
/// Thread:  store(): one; load(): any. Orders as given, or stronger.   RT: yes.
template <class T>
class Wide {
 public:
  Wide() noexcept : value_(T{}) {}
  explicit Wide(T value) noexcept : value_(value) {}
  T load(std::memory_order order = std::memory_order_relaxed) const noexcept { return value_.load(order); }
  void store(T value, std::memory_order order = std::memory_order_relaxed) noexcept { value_.store(value, order); }

 private:
  static_assert(sizeof(T) == 8 || std::atomic<T>::is_always_lock_free);
  std::conditional_t<std::atomic<T>::is_always_lock_free, std::atomic<T>, WideInHalves<T>> value_;
};

/// A sum in two words, neither of which waits for the other. The upper word counts how often the highest bit of the
/// lower word has changed. So a reader sees from that bit whether it has met a change that is not counted yet.
/// Thread:  any, no two of which are 2^31 apart.   RT: yes, without a lock.
class TallyInHalves {
 public:
  void add(std::uint32_t more = 1) noexcept {
    const std::uint64_t before = low_.fetch_add(more, std::memory_order_relaxed), after = before + more;
    // release: partner is value(), which sees no upper word newer than the lower one that it then reads.
    if (const auto halves = static_cast<std::uint32_t>((after >> 31) - (before >> 31)); halves != 0)
      high_.fetch_add(halves, std::memory_order_release);
  }
  std::uint64_t value() const noexcept {
    std::uint32_t high = high_.load(std::memory_order_acquire);  // before the lower one, which may then only be newer
    const std::uint32_t low = low_.load(std::memory_order_relaxed);
    if ((high & 1) != low >> 31) ++high;
    return std::uint64_t{high} << 31 | (low & ~kTop);
  }

 private:
  static constexpr std::uint32_t kTop = 1u << 31;
  std::atomic<std::uint32_t> low_{0}, high_{0};
};

class TallyAtOnce {
 public:
  void add(std::uint32_t more = 1) noexcept { value_.fetch_add(more, std::memory_order_relaxed); }
  std::uint64_t value() const noexcept { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<std::uint64_t> value_{0};
};

/// A counter to which any thread adds, up to 2^31 at a time. It orders nothing.
/// Thread:  any.   RT: yes, without a lock.
using Tally = std::conditional_t<kReadsWideAtOnce, TallyAtOnce, TallyInHalves>;

/// A number that any thread stores and any loads. Machines that do not read 64 bits at once have no way to do that with
/// 64 bits: there it has 24 bits instead of 53.
using AnybodysNumber = std::atomic<std::conditional_t<kReadsWideAtOnce, double, float>>;

}  // namespace sinew::hal
