#include <algorithm>

#include "rt/exec/runner.hpp"
#include "rt/external_source.hpp"
#include "rt/guardian.hpp"

namespace sinew::rt {

ThreadRunner::ThreadRunner(RunBoard& board, std::uint32_t thread)
    : board_(board), thread_(thread), last_release_(board.options.start) {
  for (const std::uint32_t m : board.graph.threads()[thread].modules)
    modules_.push_back(std::make_unique<ModuleRunner>(board, m));
  const ThreadSpec& spec = board.graph.threads()[thread].spec;
  if (spec.trigger == ThreadSpec::Trigger::period) stats_.period_ns.set(spec.period.count());
}

std::optional<Duration> ThreadRunner::begin(Time release, bool timed_out, Time now) noexcept {
  const std::optional<Duration> new_period = empty_mailbox(now);
  const ThreadSpec& spec = board_.graph.threads()[thread_].spec;
  const bool first_periodic = cycles_ == 0 && spec.trigger == ThreadSpec::Trigger::period;
  cycle_.dt = first_periodic ? spec.period : std::max(release - last_release_, Duration{1});
  cycle_.release = release;
  cycle_.timed_out = timed_out;
  last_release_ = release;
  ++cycles_;
  begun_ = now;
  stats_.lateness.add(now - release);
  timeline().add(TimelineEvent::Kind::release, release, now - release);
  return new_period;
}

void ThreadRunner::end(Time now) noexcept {
  stats_.exec.add(now - begun_);
  timeline().add(TimelineEvent::Kind::cycle, begun_, now - begun_);
}

std::span<const std::uint32_t> ThreadRunner::start(std::uint32_t position, Time now) noexcept {
  return modules_[position]->start(cycle_, now);
}

std::span<const std::uint32_t> ThreadRunner::complete(std::uint32_t position, Time now, Duration exec) noexcept {
  return modules_[position]->complete(now, exec);
}

std::optional<Duration> ThreadRunner::empty_mailbox(Time now) noexcept {
  Mailbox& mailbox = board_.graph.mailbox(thread_);
  std::optional<Duration> new_period;
  while (const Request* request = mailbox.take()) {
    const Effect effect = apply(*request);
    if (request->kind == Request::Kind::set_period) new_period = Duration{stats_.period_ns.value()};
    if (board_.options.observer) board_.options.observer->taken(*request, effect, now);
    mailbox.done(effect);
  }
  return new_period;
}

Effect ThreadRunner::apply(const Request& request) noexcept {
  if (request.kind == Request::Kind::set_period) {
    stats_.period_ns.set(std::get<std::int64_t>(request.value));
    return {cycles_};
  }
  const GraphModule& about = board_.graph.modules()[request.module];
  ModuleRunner& module = *modules_[about.position];
  bool refused = false;
  switch (request.kind) {
    case Request::Kind::set_param:
      module.set_param(request);
      break;
    case Request::Kind::enable:
    case Request::Kind::disable:
      module.set_enabled(request.kind == Request::Kind::enable);
      break;
    case Request::Kind::arm:
      refused = !about.guardian->arm();
      break;
    case Request::Kind::disarm:
      about.guardian->disarm();
      break;
    case Request::Kind::message:
      about.external->take(request.index);
      break;
    case Request::Kind::set_period:
      break;  // of the thread, above
  }
  return {module.next_step(), refused};
}

Runner::Runner(Graph& graph, const RunnerOptions& options) : board_(graph, options) {
  for (std::uint32_t t = 0; t < graph.threads().size(); ++t)
    threads_.push_back(std::make_unique<ThreadRunner>(board_, t));
}

void Runner::set_start(Time start) {
  for (auto& thread : threads_) thread->set_start(start);
}

const ModuleStats& Runner::module_stats(std::uint32_t module) {
  const GraphModule& m = board_.graph.modules()[module];
  return threads_[m.thread]->module(m.position).stats();
}

std::uint64_t Runner::topic_drops(std::uint32_t topic) {
  std::uint64_t drops = 0;
  for (const GraphModule& m : board_.graph.modules())
    for (std::size_t p = 0; p < m.topic.size(); ++p)
      if (m.topic[p] == topic) drops += threads_[m.thread]->module(m.position).port_drops()[p].value();
  return drops;
}

}  // namespace sinew::rt
