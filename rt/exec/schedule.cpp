#include "rt/exec/schedule.hpp"

#include <algorithm>
#include <utility>

namespace sinew::rt {

using hal::kNever;

Schedule::Schedule(std::vector<ScheduleThread> threads, std::uint32_t cores, Time start, ScheduleClient& client)
    : client_(client), running_(cores, -1), now_(start) {
  const std::uint64_t all = cores >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << cores) - 1;
  for (ScheduleThread& spec : threads) {
    Thread t;
    for (const int cpu : spec.cpus) t.cores |= std::uint64_t{1} << cpu;
    t.cores = spec.cpus.empty() ? all : t.cores & all;
    const bool periodic = spec.trigger == ThreadSpec::Trigger::period;
    const bool catches_up = spec.overrun == ThreadSpec::Overrun::catch_up;
    std::uint32_t may_wait = periodic ? 0 : 1;
    if (periodic && catches_up) may_wait = spec.catch_up_max;
    t.waiting.resize(may_wait);
    if (periodic) t.next_period = start + spec.phase;
    if (!periodic && spec.timeout > Duration{0}) t.timeout_at = start + spec.timeout;
    t.spec = std::move(spec);
    threads_.push_back(std::move(t));
  }
  order_.reserve(threads_.size());
}

void Schedule::trigger(std::uint32_t thread) { act_as_trigger(threads_[thread], false); }

void Schedule::announce(std::uint32_t thread, Time at) { threads_[thread].device_ready = std::max(at, now_); }

void Schedule::restart_period(std::uint32_t thread, Duration period) {
  Thread& t = threads_[thread];
  t.spec.period = period;
  t.next_period = now_ + period;
}

void Schedule::run_until(Time until) {
  if (changed_) process_instant();  // triggered between two calls: acts at the instant that was reached
  for (Time t = next_instant(); t <= until && t != kNever; t = next_instant()) {
    now_ = t;
    process_instant();
  }
  now_ = std::max(now_, until);
}

Time Schedule::next_instant() const {
  Time next = kNever;
  for (const Thread& t : threads_) {
    next = std::min({next, t.next_period, t.device_ready, t.timeout_at});
    if (t.cycle.stepping && t.cycle.core >= 0) next = std::min(next, t.cycle.ends_at);
  }
  return next;
}

void Schedule::process_instant() {
  complete_steps();
  for (std::uint32_t i = 0; i < threads_.size(); ++i) release(i);
  do {
    decide_who_runs();
    start_steps();  // a raw topic filled by collect() may trigger a thread: then it is decided again
  } while (changed_);
}

void Schedule::complete_steps() {
  for (std::uint32_t i = 0; i < threads_.size(); ++i) {
    Cycle& c = threads_[i].cycle;
    if (!c.stepping || c.core < 0 || c.ends_at > now_) continue;
    client_.complete(i, c.module, now_);
    c.stepping = false;
    if (++c.module == threads_[i].spec.modules) finish_cycle(threads_[i]);
  }
}

void Schedule::finish_cycle(Thread& t) {
  ++t.counters.completions;
  running_[static_cast<std::size_t>(t.cycle.core)] = -1;
  t.cycle = {};
  if (t.waiting_count == 0) return;
  const CycleInfo info = t.waiting[t.waiting_first];
  t.waiting_first = (t.waiting_first + 1) % static_cast<std::uint32_t>(t.waiting.size());
  --t.waiting_count;
  make_cycle(t, info);
}

void Schedule::make_cycle(Thread& t, const CycleInfo& info) {
  t.cycle.exists = true;
  t.cycle.info = info;
  changed_ = true;
}

void Schedule::release(std::uint32_t thread) {
  Thread& t = threads_[thread];
  if (t.next_period <= now_) release_periodic(thread);
  if (t.device_ready <= now_) {
    t.device_ready = kNever;
    act_as_trigger(t, false);
  }
  if (t.timeout_at <= now_) act_as_trigger(t, true);
}

void Schedule::release_periodic(std::uint32_t thread) {
  Thread& t = threads_[thread];
  const CycleInfo info{t.next_period, false};
  t.next_period = t.next_period + t.spec.period;
  if (!t.cycle.exists) {
    ++t.counters.releases;
    make_cycle(t, info);
    return;
  }
  ++t.counters.overruns;
  const bool dropped = t.waiting_count == t.waiting.size();
  client_.overrun(thread, info.release, dropped);
  if (dropped) {
    ++t.counters.skips;
    return;
  }
  ++t.counters.releases;
  t.waiting[(t.waiting_first + t.waiting_count++) % t.waiting.size()] = info;
}

void Schedule::act_as_trigger(Thread& t, bool timed_out) {
  if (t.spec.timeout > Duration{0}) t.timeout_at = now_ + t.spec.timeout;
  const bool waits = t.cycle.exists;
  if (waits && (!t.cycle.begun || t.waiting_count == t.waiting.size())) {
    ++t.counters.coalesced;
    return;
  }
  ++t.counters.releases;
  if (timed_out) ++t.counters.timeouts;
  if (waits)
    t.waiting[(t.waiting_first + t.waiting_count++) % t.waiting.size()] = {now_, timed_out};
  else
    make_cycle(t, {now_, timed_out});
}

bool Schedule::before(std::uint32_t a, std::uint32_t b) const {
  const Thread &s = threads_[a], &t = threads_[b];
  if (s.spec.priority != t.spec.priority) return s.spec.priority > t.spec.priority;
  if (s.cycle.begun != t.cycle.begun) return s.cycle.begun;
  if (s.cycle.begun && s.cycle.begin_order != t.cycle.begin_order) return s.cycle.begin_order < t.cycle.begin_order;
  return a < b;
}

/// The core that this cycle takes, given those taken by more urgent ones; -1: none.
int Schedule::core_for(const Thread& t, std::uint64_t taken) const {
  const std::uint64_t open = t.cores & ~taken;
  if (t.cycle.core >= 0 && (open >> t.cycle.core & 1)) return t.cycle.core;
  int last = -1;
  for (int core = 0; core < static_cast<int>(running_.size()); ++core) {
    if (!(open >> core & 1)) continue;
    const int runs = running_[static_cast<std::size_t>(core)];
    if (runs < 0) return core;
    if (last < 0 ||
        before(static_cast<std::uint32_t>(running_[static_cast<std::size_t>(last)]), static_cast<std::uint32_t>(runs)))
      last = core;
  }
  return last;
}

void Schedule::decide_who_runs() {
  changed_ = false;
  order_.clear();
  for (std::uint32_t i = 0; i < threads_.size(); ++i)
    if (threads_[i].cycle.exists) order_.push_back(i);
  std::sort(order_.begin(), order_.end(), [this](auto a, auto b) { return before(a, b); });

  std::uint64_t taken = 0;
  for (const std::uint32_t i : order_) {
    Thread& t = threads_[i];
    Cycle& c = t.cycle;
    const int core = core_for(t, taken);
    if (core >= 0) taken |= std::uint64_t{1} << core;
    if (c.core >= 0 && core < 0) {
      ++t.counters.preemptions;
      c.preempted_at = now_;
      if (c.stepping) c.left = c.ends_at - now_;
    } else if (c.core < 0 && core >= 0) {
      if (c.stepping) c.ends_at = now_ + c.left;
      if (c.preempted_at != kNever) client_.resumed(i, std::exchange(c.preempted_at, kNever), now_);
    }
    c.core = core;
  }
  std::fill(running_.begin(), running_.end(), -1);
  for (const std::uint32_t i : order_)
    if (threads_[i].cycle.core >= 0) running_[static_cast<std::size_t>(threads_[i].cycle.core)] = static_cast<int>(i);
}

void Schedule::start_steps() {
  for (const std::uint32_t i : order_) {
    Cycle& c = threads_[i].cycle;
    if (c.core < 0 || c.stepping) continue;
    if (!c.begun) {
      c.begun = true;
      c.begin_order = begins_++;
    }
    const Duration takes = client_.start(i, c.module, c.info, now_);
    c.stepping = true;
    c.ends_at = now_ + std::max(takes, Duration{1});
  }
}

}  // namespace sinew::rt
