#include "rt/exec/gap_watch.hpp"

#include <algorithm>

namespace sinew::rt {
namespace {

// The throttle acts when all but the `frozen` share is used. A little less counts too: we do not see all use.
bool is_nearly_all(Duration used, Duration of) { return used * 100 >= of * 85; }

}  // namespace

void GapWatch::begin(Time now) noexcept {
  last_ = now;
  marks_.fill({now, {}, os_.thread_cpu_time()});
  awake_since_ns_.store(now.ns, std::memory_order_relaxed);
  asleep_.store(false, std::memory_order_relaxed);
}

std::optional<GapWatch::Gap> GapWatch::woke(Time due, Time now) noexcept {
  const Time ready = std::max(due, last_);  // an earlier release was late because of the cycle, not of the processor
  if (due > last_) {
    slept_ += due - last_;
    awake_since_ns_.store(due.ns, std::memory_order_relaxed);
  }
  last_ = now;
  asleep_.store(false, std::memory_order_relaxed);
  if (now - ready < kGap) return std::nullopt;
  mark(now);  // so that ran() does not report the same gap
  return judge(now - ready, now - ready);
}

std::optional<GapWatch::Gap> GapWatch::ran(Time now) noexcept {
  const Duration cycle = now - last_;
  last_ = now;
  asleep_.store(true, std::memory_order_relaxed);
  const Mark before = marks_[newest_];
  if (cycle < kGap && now - before.at < kMarkPeriod) return std::nullopt;
  mark(now);
  if (cycle < kGap) return std::nullopt;
  const Mark& after = marks_[newest_];
  const Duration lost = (after.at - before.at) - (after.cpu - before.cpu) - (after.slept - before.slept);
  if (lost < kGap) return std::nullopt;
  return judge(std::min(lost, cycle), cycle);
}

bool GapWatch::busy(Time now) const noexcept {
  const Time since{awake_since_ns_.load(std::memory_order_relaxed)};
  const bool awake = !asleep_.load(std::memory_order_relaxed);
  return now.ns < busy_until_ns_.load(std::memory_order_relaxed) ||
         (awake && is_nearly_all(now - since, throttle_.period - throttle_.frozen));
}

/// Stores the time used until now, and whether that was nearly all of the last throttle period.
void GapWatch::mark(Time now) noexcept {
  newest_ = (newest_ + 1) % kMarks;
  marks_[newest_] = {now, slept_, os_.thread_cpu_time()};
  const Duration span = throttle_.period - throttle_.frozen;
  const Mark* before = nullptr;  // the newest that is a whole span ago, gaps included
  for (const Mark& m : marks_)
    if (now - m.at >= span && (!before || m.at > before->at)) before = &m;
  const bool all = before && is_nearly_all((now - before->at) - (slept_ - before->slept), now - before->at);
  busy_until_ns_.store(all ? (now + throttle_.period).ns : 0, std::memory_order_relaxed);
}

/// `over`: the length of time in which `lost` was lost.
GapWatch::Gap GapWatch::judge(Duration lost, Duration over) const noexcept {
  const Duration one = throttle_.frozen;
  if (one <= Duration{0}) return {lost, 1, false};
  const std::int64_t times = std::max<std::int64_t>(1, (lost + one / 2) / one);
  const Duration off = lost > one * times ? lost - one * times : one * times - lost;
  // A fifth: the kernel freezes at ticks, and the wake-up adds its own lateness.
  if (off * 5 > one * times || throttle_.period * (times - 1) > over) return {lost, 1, false};
  return {lost / times, static_cast<std::uint32_t>(times), true};
}

}  // namespace sinew::rt
