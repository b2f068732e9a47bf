#pragma once
// The kernel's wait and wake on a 32-bit word, for which the C library has no function.
#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <climits>
#include <ctime>

#include "hal/os.hpp"

namespace sinew::hal {

/// 32-bit machines have the call twice; the later one, since Linux 5.1, takes the 64-bit time of our `timespec`.
#ifdef SYS_futex_time64
inline constexpr long kFutexCall = SYS_futex_time64;
#else
inline constexpr long kFutexCall = SYS_futex;
#endif

/// The processes that share the word: one, or all of the machine.
enum class FutexScope : int { process = FUTEX_PRIVATE_FLAG, machine = 0 };

/// Sleeps while `word` is `expected`, until `deadline` at most; may return early for no reason.
/// Thread:  any.   RT: blocks.
inline void futex_wait(const WakeWord& word, std::uint32_t expected, Time deadline, FutexScope scope) noexcept {
  const timespec until{.tv_sec = static_cast<time_t>(deadline.ns / 1'000'000'000),
                       .tv_nsec = static_cast<long>(deadline.ns % 1'000'000'000)};
  ::syscall(kFutexCall, &word, FUTEX_WAIT_BITSET | static_cast<int>(scope), expected,
            deadline == kNever ? nullptr : &until, nullptr, FUTEX_BITSET_MATCH_ANY);
}

/// Wakes up to `count` of those who sleep on it.
/// Thread:  any.   RT: yes.
inline void futex_wake(const WakeWord& word, int count, FutexScope scope) noexcept {
  ::syscall(kFutexCall, &word, FUTEX_WAKE | static_cast<int>(scope), count, nullptr, nullptr, 0);
}

}  // namespace sinew::hal
