#include "record/run/step_counts.hpp"

#include <algorithm>

namespace sinew::record {
namespace {

constexpr std::size_t kMostEvents = 100'000;

/// Times of a file may be any numbers: the difference wraps instead of overflowing.
rt::Duration between(rt::Time from, rt::Time to) {
  return rt::Duration{
      static_cast<std::int64_t>(static_cast<std::uint64_t>(to.ns) - static_cast<std::uint64_t>(from.ns))};
}

}  // namespace

StepCounts::StepCounts(std::size_t threads, std::size_t modules)
    : module_count_(modules),
      threads_(std::make_unique<rt::ThreadStats[]>(threads)),
      modules_(std::make_unique<rt::ModuleStats[]>(modules)),
      cycles_(threads) {}

void StepCounts::add(std::span<const LoggedStep> steps) {
  const std::lock_guard lock(mutex_);
  for (const LoggedStep& step : steps)
    if (step.thread < cycles_.size() && step.module < module_count_) add(step);
}

void StepCounts::add(const LoggedStep& s) {
  rt::ThreadStats& thread = threads_[s.thread];
  Cycle& cycle = cycles_[s.thread];
  if (!cycle.begun || s.release != cycle.release) {
    if (cycle.begun && s.release < cycle.release)
      forget(s.thread, s.release);  // the time went back: what follows comes again
    else if (cycle.begun)
      complete(s.thread, cycle);
    cycle = {true, s.release, s.now, s.completed};
    thread.releases.add();
    thread.lateness.add(between(s.release, s.now));
    if (s.timed_out) thread.timeouts.add();
    put({rt::TimelineEvent::Kind::release, s.thread, rt::kNone, s.release, between(s.release, s.now)});
  }
  cycle.completed = s.completed;
  rt::ModuleStats& module = modules_[s.module];
  module.steps.add();
  if (s.status == rt::StepStatus::ok) module.ok.add();
  if (s.status == rt::StepStatus::stale) module.stale.add();
  if (s.status == rt::StepStatus::fault) module.fault.add();
  module.exec.add(s.exec);
  put({rt::TimelineEvent::Kind::step, s.thread, s.module, s.now, between(s.now, s.completed)});
}

void StepCounts::complete(std::uint32_t thread, Cycle& cycle) {
  const rt::Duration length = between(cycle.first, cycle.completed);
  threads_[thread].completions.add();
  threads_[thread].exec.add(length);
  put({rt::TimelineEvent::Kind::cycle, thread, rt::kNone, cycle.first, length});
}

void StepCounts::put(const rt::TimelineEvent& event) {
  if (events_.size() == kMostEvents) events_.pop_front();
  events_.push_back(event);
}

void StepCounts::forget(std::uint32_t thread, rt::Time from) {
  std::erase_if(events_, [&](const auto& e) { return e.thread == thread && e.at >= from; });
}

std::vector<rt::TimelineEvent> StepCounts::timeline(rt::Time until, rt::Duration last) const {
  std::vector<rt::TimelineEvent> events;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& e : events_)
      if (e.at <= until && between(e.at, until) <= last) events.push_back(e);
  }
  std::stable_sort(events.begin(), events.end(), [](const auto& a, const auto& b) {
    return a.at != b.at ? a.at < b.at : a.length > b.length;  // outer before inner
  });
  return events;
}

}  // namespace sinew::record
