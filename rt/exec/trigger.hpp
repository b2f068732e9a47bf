#pragma once
// What releases a thread that waits for topics or a device: a word to sleep on that counts triggers.
#include <algorithm>
#include <atomic>

#include "hal/device.hpp"
#include "hal/os.hpp"
#include "rt/exec/instant_word.hpp"
#include "rt/step.hpp"

namespace sinew::rt {

/// Counts triggers in the upper 31 bits of a word. Bit 0 says that the owner sleeps: only then is the kernel entered.
/// The owner is one thread, triggers come from any.
///
/// No wake-up is lost: the owner sets bit 0 by an exchange that fails when the count has moved since it looked, and the
/// kernel puts it to sleep only while the word still is what the exchange left. All are changes of one word, so each
/// trigger comes either before the exchange (which fails), or between it and the kernel's look (which refuses), or
/// after it; a trigger after the exchange finds bit 0 and wakes. Bit 0 is written by the owner alone and is 0 whenever
/// the owner is awake, apart from the instant between waking and clearing it, which costs a needless wake.
///
/// No instant is stale: a trigger offers its instant before it counts itself, take() takes the count before it takes
/// the instant. By the word's release and acquire an instant whose trigger is in the count was offered before it is
/// taken, so what is offered after that belongs to a trigger that is still to come.
class Trigger final : public hal::Wake {
 public:
  struct Taken {
    std::uint32_t count;
    Time first, latest;  // instants of the triggers; about, when several threads fire at once
  };

  explicit Trigger(hal::Os& os) : os_(os) {}

  /// Thread: any.   RT: yes.
  void fire(Time now) noexcept {
    auto none = Instant::kNone;
    if (first_.load(std::memory_order_relaxed) == none)
      first_.compare_exchange_strong(none, Instant::of(now), std::memory_order_relaxed);
    latest_.store(Instant::of(now), std::memory_order_relaxed);
    // release: partner is waiting(); a thread that sees the count sees the commit behind it and the instants.
    if (word_.fetch_add(2, std::memory_order_release) & 1) os_.wake(word_);
  }
  void wake() noexcept override { fire(os_.now()); }

  // ---- the owner's side
  /// Triggers not yet taken.
  std::uint32_t waiting() const noexcept {
    return ((word_.load(std::memory_order_acquire) >> 1) - taken_) & kCountMask;
  }
  /// Takes all triggers that wait. RT: yes.
  Taken take() noexcept {
    const std::uint32_t n = waiting();
    if (n == 0) return {};
    taken_ = (taken_ + n) & kCountMask;
    const auto now = [this] { return os_.now(); };
    const Time latest = Instant::time(latest_.load(std::memory_order_relaxed), now);
    const auto first = first_.exchange(Instant::kNone, std::memory_order_relaxed);
    // No instant was offered when this trigger met another offer that was just being taken: it is from now.
    return {n, first == Instant::kNone ? std::max(latest, os_.now()) : Instant::time(first, now), latest};
  }
  /// Sleeps until a trigger waits or the deadline has passed. False: the deadline.
  bool wait(Time deadline) noexcept {
    while (waiting() == 0) {
      if (deadline != hal::kNever && os_.now() >= deadline) return false;
      std::uint32_t seen = taken_ << 1;  // acquire in waiting(): this exchange need not order anything
      if (!word_.compare_exchange_strong(seen, seen | 1, std::memory_order_relaxed)) continue;
      os_.wait(word_, seen | 1, deadline);
      word_.fetch_and(~std::uint32_t{1}, std::memory_order_relaxed);
    }
    return true;
  }

 private:
  static constexpr std::uint32_t kCountMask = 0x7FFFFFFF;
  using Instant = InstantWord<>;
  hal::Os& os_;
  hal::WakeWord word_{0};
  std::uint32_t taken_ = 0;  // the owner's own
  std::atomic<Instant::Word> first_{Instant::kNone}, latest_{Instant::kNone};
};

}  // namespace sinew::rt
