#include <algorithm>

#include "rt/runner.hpp"

namespace sinew::rt {

ThreadRunner::ThreadRunner(RunBoard& board, std::uint32_t thread)
    : board_(board), thread_(thread), last_release_(board.options.start) {
  for (const std::uint32_t m : board.graph.threads()[thread].modules)
    modules_.push_back(std::make_unique<ModuleRunner>(board, m));
}

void ThreadRunner::begin(Time release, bool timed_out, Time now) noexcept {
  empty_mailbox();
  const ThreadSpec& spec = board_.graph.threads()[thread_].spec;
  const bool first_periodic = first_ && spec.trigger == ThreadSpec::Trigger::period;
  cycle_.dt = first_periodic ? spec.period : std::max(release - last_release_, Duration{1});
  cycle_.release = release;
  cycle_.timed_out = timed_out;
  last_release_ = release;
  first_ = false;
  begun_ = now;
  stats_.lateness.add(now - release);
}

void ThreadRunner::end(Time now) noexcept { stats_.exec.add(now - begun_); }

std::span<const std::uint32_t> ThreadRunner::start(std::uint32_t position, Time now) noexcept {
  return modules_[position]->start(cycle_, now);
}

std::span<const std::uint32_t> ThreadRunner::complete(std::uint32_t position, Time now, Duration exec) noexcept {
  return modules_[position]->complete(now, exec);
}

void ThreadRunner::empty_mailbox() noexcept {
  Mailbox& mailbox = board_.graph.mailbox(thread_);
  while (const Request* request = mailbox.take()) {
    ModuleRunner& module = *modules_[board_.graph.modules()[request->module].position];
    if (request->kind == Request::Kind::set_param)
      module.set_param(*request);
    else
      module.set_enabled(request->kind == Request::Kind::enable);
    mailbox.done(module.next_step());
  }
}

Runner::Runner(Graph& graph, const RunnerOptions& options) : board_(graph, options) {
  for (std::uint32_t t = 0; t < graph.threads().size(); ++t)
    threads_.push_back(std::make_unique<ThreadRunner>(board_, t));
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
