#include "rt/exec/discrete_executor.hpp"

#include <algorithm>

#include "math/convert.hpp"
#include "math/hash.hpp"
#include "math/random.hpp"
#include "rt/exec/fp_mode.hpp"

namespace sinew::rt {
namespace {

std::vector<ScheduleThread> schedule_threads(const Graph& graph) {
  std::vector<ScheduleThread> all;
  for (const GraphThread& t : graph.threads()) {
    ScheduleThread s;
    s.priority = t.spec.priority;
    s.cpus = t.spec.cpus;
    s.trigger = t.spec.trigger;
    s.period = t.spec.period;
    s.phase = t.spec.phase;
    s.timeout = t.spec.timeout;
    s.overrun = t.spec.overrun;
    s.catch_up_max = t.spec.catch_up_max;
    s.modules = static_cast<std::uint32_t>(t.modules.size());
    all.push_back(std::move(s));
  }
  return all;
}

Time end_of(const DiscreteOptions& o) {
  return o.duration.count() > INT64_MAX - o.start.ns ? Time{INT64_MAX - 1} : o.start + o.duration;
}

/// A random stream apart from that of the module's own draws.
std::uint32_t exec_stream(const std::string& module) {
  const std::uint64_t h = math::fnv1a64("exec " + module);
  return static_cast<std::uint32_t>(h ^ h >> 32);
}

Duration scaled(Duration d, double factor) {
  return Duration{math::to_integer<std::int64_t>(static_cast<double>(d.count()) * factor)};
}

/// The time that a share `u` of all steps does not exceed.
Duration at_quantile(const std::vector<ExecModel::Quantile>& points, double u) {
  const ExecModel::Quantile* below = &points.front();
  for (const ExecModel::Quantile& above : points) {
    if (u > above.share) {
      below = &above;
      continue;
    }
    const double width = above.share - below->share;
    return width > 0 ? below->exec + scaled(above.exec - below->exec, (u - below->share) / width) : above.exec;
  }
  return points.back().exec;
}

}  // namespace

DiscreteExecutor::DiscreteExecutor(Graph& graph, hal::ManualClock& clock, hal::GrantSource& grants,
                                   const DiscreteOptions& options)
    : graph_(graph),
      clock_(clock),
      grants_(grants),
      options_(options),
      runner_(graph, {options.start, options.hash_topics, options.fault_limit, options.observer, &clock}),
      schedule_(schedule_threads(graph), graph.spec().virtual_cores, options.start, *this),
      device_(graph.threads().size()),
      announced_(graph.threads().size(), hal::kNever) {
  for (const GraphModule& m : graph.modules()) models_.push_back({&m.spec.exec, exec_stream(m.spec.name)});
  for (std::size_t t = 0; t < device_.size(); ++t)
    if (graph.threads()[t].device_module != kNone)
      device_[t] = graph.modules()[graph.threads()[t].device_module].driver->device();
}

hal::Result<DiscreteReport> DiscreteExecutor::run() {
  const bool measures = std::any_of(models_.begin(), models_.end(),
                                    [](const Model& m) { return m.exec->kind == ExecModel::Kind::measured; });
  if (measures && !options_.os)
    return hal::Error{hal::Errc::not_supported, "measured execution times need an Os to ask for CPU time"};
  const FpModeScope fp_mode;
  if (!FpMode::computes_right()) return hal::Error{hal::Errc::not_supported, "rounding to nearest with subnormals"};
  const DiscreteReport report = run_to_end();
  copy_counters();
  return report;
}

DiscreteReport DiscreteExecutor::run_to_end() {
  using End = DiscreteReport::End;
  const Time end = end_of(options_);
  Time done = options_.start;
  clock_.set(done);
  for (;;) {
    if (stop_.load(std::memory_order_relaxed)) return {End::stop_requested, done};
    const hal::Result<Time> grant = grants_.next_grant(done);
    if (!grant && grant.error().code == hal::Errc::closed) return {End::source_closed, done, grant.error()};
    if (!grant) return {End::source_failed, done, grant.error()};
    if (*grant < done) return {End::source_failed, done, {hal::Errc::bad_data, "a grant goes back", grant->ns}};
    announce_all();
    done = std::min(*grant, end);
    schedule_.run_until(done);
    clock_.set(done);
    copy_counters();
    if (done == end) return {End::duration, done};
  }
}

Duration DiscreteExecutor::start(std::uint32_t thread, std::uint32_t position, const CycleInfo& cycle,
                                 Time now) noexcept {
  clock_.set(now);
  ThreadRunner& runner = runner_.thread(thread);
  if (position == 0)
    if (const auto period = runner.begin(cycle.release, cycle.timed_out, now))
      schedule_.restart_period(thread, *period);
  const std::uint32_t module = graph_.threads()[thread].modules[position];
  Model& model = models_[module];
  const bool measures = model.exec->kind == ExecModel::Kind::measured;
  const Duration before = measures ? options_.os->thread_cpu_time() : Duration{};
  const auto filled = runner.start(position, now);
  const Duration measured = measures ? options_.os->thread_cpu_time() - before : Duration{};
  trigger_readers(filled);
  if (graph_.threads()[thread].device_module == module && runner.module(position).stepping())
    announce(thread, device_[thread]->ready_at());
  const ModuleRunner& stepped = runner.module(position);
  const std::uint32_t step = stepped.next_step() - 1;
  model.now = stepped.stepping() ? std::max(model_time(model, measured, step), Duration{1}) : Duration{1};
  return model.now;
}

void DiscreteExecutor::complete(std::uint32_t thread, std::uint32_t position, Time now) noexcept {
  clock_.set(now);
  ThreadRunner& runner = runner_.thread(thread);
  trigger_readers(runner.complete(position, now, models_[graph_.threads()[thread].modules[position]].now));
  if (position + 1 == runner.size()) runner.end(now);
}

void DiscreteExecutor::overrun(std::uint32_t thread, Time release, bool dropped) noexcept {
  runner_.thread(thread).timeline().add(dropped ? TimelineEvent::Kind::skip : TimelineEvent::Kind::overrun, release);
}

void DiscreteExecutor::resumed(std::uint32_t thread, Time preempted_at, Time now) noexcept {
  runner_.thread(thread).timeline().add(TimelineEvent::Kind::preempted, preempted_at, now - preempted_at);
}

Duration DiscreteExecutor::model_time(Model& model, Duration measured, std::uint32_t step) {
  const ExecModel& e = *model.exec;
  switch (e.kind) {
    case ExecModel::Kind::constant:
      return e.constant;
    case ExecModel::Kind::trace: {
      const Duration d = e.trace[model.next];
      model.next = (model.next + 1) % e.trace.size();
      return d;
    }
    case ExecModel::Kind::measured:
      return scaled(measured, e.factor);
    case ExecModel::Kind::quantiles:
      return scaled(at_quantile(e.quantiles, math::Random(graph_.spec().seed, model.stream, step).uniform()), e.factor);
    case ExecModel::Kind::none:
      break;  // refused by the check
  }
  return Duration{1};
}

void DiscreteExecutor::trigger_readers(std::span<const std::uint32_t> topics) noexcept {
  for (const std::uint32_t topic : topics)
    for (const std::uint32_t thread : graph_.topics()[topic].triggers) schedule_.trigger(thread);
}

/// After a grant the devices know their samples up to it. An instant that a device has already announced is not
/// announced again: its trigger is still to come, or waits for its cycle.
void DiscreteExecutor::announce_all() noexcept {
  for (std::uint32_t t = 0; t < device_.size(); ++t) {
    if (!device_[t]) continue;
    const Time ready = device_[t]->ready_at();
    if (ready != announced_[t]) announce(t, ready);
  }
}

void DiscreteExecutor::announce(std::uint32_t thread, Time ready) noexcept {
  announced_[thread] = ready;
  schedule_.announce(thread, ready);
}

void DiscreteExecutor::copy_counters() noexcept {
  for (std::uint32_t t = 0; t < device_.size(); ++t) {
    const ScheduleCounters& from = schedule_.counters(t);
    ThreadStats& to = runner_.thread(t).stats();
    to.releases.set(from.releases);
    to.completions.set(from.completions);
    to.overruns.set(from.overruns);
    to.skips.set(from.skips);
    to.coalesced.set(from.coalesced);
    to.timeouts.set(from.timeouts);
    to.preemptions.set(from.preemptions);
  }
}

}  // namespace sinew::rt
