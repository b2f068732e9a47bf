#include "apps/search/schedule_check.hpp"

#include <fmt/format.h>

namespace sinew::search {
namespace {

using rt::ThreadSpec;

bool periodic(const ThreadSpec& spec) { return spec.trigger == ThreadSpec::Trigger::period; }

}  // namespace

ScheduleCheck::ScheduleCheck(const rt::Graph& graph, Verdict& verdict)
    : graph_(graph), verdict_(verdict), seen_(graph.modules().size()) {}

void ScheduleCheck::completed(const rt::StepRecord& r) {
  Seen& seen = seen_[r.module];
  const std::string& name = graph_.modules()[r.module].spec.name;
  if (r.number != seen.steps)
    verdict_.fail("steps", r.completed, fmt::format("{}: step {} came where {} was next", name, r.number, seen.steps));
  if (r.now < r.release || r.completed - r.now < r.exec)
    verdict_.fail("steps", r.completed,
                  fmt::format("{}: released {}, started {}, executed {}, completed {} ns", name, r.release.ns, r.now.ns,
                              r.exec.count(), r.completed.ns));
  if (periodic(graph_.threads()[r.thread].spec)) check_periodic(r, seen);
  ++seen.steps;
  seen.release = r.release;
}

void ScheduleCheck::check_periodic(const rt::StepRecord& r, const Seen& seen) {
  const ThreadSpec& spec = graph_.threads()[r.thread].spec;
  const std::string& name = graph_.modules()[r.module].spec.name;
  const std::int64_t since = r.release.ns - spec.phase.count();
  if (since < 0 || since % spec.period.count() != 0)
    verdict_.fail(
        "phase", r.completed,
        fmt::format("{}: released at {} ns, which is not on the grid of thread {}", name, r.release.ns, spec.name));
  const bool first = seen.release.ns < 0;
  const rt::Duration dt = first ? spec.period : r.release - seen.release;
  if (r.dt != dt)
    verdict_.fail("phase", r.completed,
                  fmt::format("{}: dt is {} ns, release to release {} ns", name, r.dt.count(), dt.count()));
}

void ScheduleCheck::look(msg::Time now, rt::Runner& runner) {
  if (verdict_.failed()) return;
  for (std::uint32_t t = 0; t < graph_.threads().size(); ++t) check_thread(now, t, runner.thread_stats(t));
  for (std::uint32_t m = 0; m < graph_.modules().size(); ++m) {
    const std::uint32_t thread = graph_.modules()[m].thread;
    check_module(now, m, runner.module_stats(m), runner.thread_stats(thread).completions.value());
  }
}

void ScheduleCheck::check_thread(msg::Time now, std::uint32_t thread, const rt::ThreadStats& stats) {
  const ThreadSpec& spec = graph_.threads()[thread].spec;
  const std::uint64_t releases = stats.releases.value(), skips = stats.skips.value();
  const std::uint64_t completions = stats.completions.value();
  const bool catches_up = periodic(spec) && spec.overrun == ThreadSpec::Overrun::catch_up;
  std::uint64_t may_wait = periodic(spec) ? 0 : 1;
  if (catches_up) may_wait = spec.catch_up_max;
  if (completions > releases || releases - completions > 1 + may_wait)
    verdict_.fail("counters", now,
                  fmt::format("thread {}: {} releases, {} completions", spec.name, releases, completions));
  if (stats.overruns.value() < skips)
    verdict_.fail("counters", now,
                  fmt::format("thread {}: {} skips, {} overruns", spec.name, skips, stats.overruns.value()));
  if (!periodic(spec) || now.ns < spec.phase.count()) return;
  const auto due = static_cast<std::uint64_t>((now.ns - spec.phase.count()) / spec.period.count() + 1);
  if (releases + skips != due)
    verdict_.fail("counters", now,
                  fmt::format("thread {}: {} releases and {} skips in {} periods", spec.name, releases, skips, due));
}

void ScheduleCheck::check_module(msg::Time now, std::uint32_t module, const rt::ModuleStats& stats,
                                 std::uint64_t completions) {
  const std::string& name = graph_.modules()[module].spec.name;
  const std::uint64_t steps = stats.steps.value();
  const std::uint64_t parts = stats.ok.value() + stats.stale.value() + stats.fault.value();
  if (steps != parts || steps != seen_[module].steps || stats.exec.count() != steps)
    verdict_.fail("counters", now,
                  fmt::format("{}: {} steps, of which {} ok, stale or fault, {} seen, {} timed", name, steps, parts,
                              seen_[module].steps, stats.exec.count()));
  if (stats.stopped.value() == 0 && (steps < completions || steps > completions + 1))
    verdict_.fail("counters", now, fmt::format("{}: {} steps in {} cycles", name, steps, completions));
}

}  // namespace sinew::search
