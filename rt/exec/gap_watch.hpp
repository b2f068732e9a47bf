#pragma once
// Finds long times in which a thread was ready but had no processor, and tells those made by the kernel's real-time
// throttle from the rest.
#include <array>
#include <atomic>
#include <optional>

#include "hal/os.hpp"
#include "hal/wide.hpp"
#include "rt/exec/stats.hpp"

namespace sinew::rt {

/// How the kernel throttles fixed priorities: threads that would use a whole period get no processor for `frozen` of
/// it. The kernel's default is 50 ms of every second; `frozen` 0: no throttle.
/// Source:  Documentation/scheduler/sched-rt-group.rst of Linux.
struct Throttle {
  Duration period = std::chrono::seconds(1);
  Duration frozen = std::chrono::milliseconds(50);
};

/// Watches one executor thread. Processor time is read ten times a second and after long cycles only.
/// Thread:  executor; busy() any.   RT: yes.
class GapWatch {
 public:
  static constexpr Duration kGap = std::chrono::milliseconds(40);  // shorter than what the throttle takes

  /// The thread was ready without a processor, `count` times for about `length` each.
  struct Gap {
    Duration length{};
    std::uint32_t count = 1;
    bool throttle_like = false;  // as long as the throttle freezes; it was the throttle if some thread was busy()
  };

  GapWatch(hal::Os& os, const Throttle& throttle) : os_(os), throttle_(throttle) {}

  /// Call first, on the watched thread.
  void begin(Time now) noexcept;
  /// The thread chose to sleep from the end of its last cycle; it should have woken at `due`, and did at `now`.
  std::optional<Gap> woke(Time due, Time now) noexcept;
  /// A cycle ran from the last woke(), or the last ran(), to `now`.
  std::optional<Gap> ran(Time now) noexcept;
  /// True if the thread used nearly all processor time until `now`, for as long as makes the kernel throttle. A frozen
  /// thread counts as running.
  bool busy(Time now) const noexcept;

 private:
  struct Mark {
    Time at;
    Duration slept{}, cpu{};
  };
  void mark(Time now) noexcept;
  Gap judge(Duration lost, Duration over) const noexcept;

  static constexpr Duration kMarkPeriod = std::chrono::milliseconds(100);
  static constexpr std::uint32_t kMarks = 16;  // somewhat more than a second of them
  hal::Os& os_;
  const Throttle throttle_;
  std::array<Mark, kMarks> marks_{};
  std::uint32_t newest_ = 0;
  Time last_{};       // end of the last cycle, or begin of this one
  Duration slept_{};  // since begin()
  // Not synchronised: a reader may see one a little before another.
  hal::Wide<std::int64_t> awake_since_ns_;  // of the last sleep's end
  hal::Wide<std::int64_t> busy_until_ns_;
  std::atomic<bool> asleep_{true};
};

}  // namespace sinew::rt
