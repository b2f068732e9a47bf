#include "rt/exec/runner.hpp"

#include <algorithm>
#include <bit>

#include "msg/compare.hpp"
#include "rt/external_source.hpp"
#include "rt/parameters.hpp"
#include "rt/saved_state.hpp"

namespace sinew::rt {
namespace {

using PortKind = Declaration::PortKind;

}  // namespace

RunBoard::RunBoard(Graph& g, const RunnerOptions& o)
    : graph(g),
      options(o),
      topics(g.topics().size()),
      hashes(o.hash_topics ? g.topics().size() : 0),
      chains(std::make_unique<ChainStats[]>(g.chains().size())),
      timeline(g, o.start) {}

ModuleRunner::ModuleRunner(RunBoard& board, std::uint32_t module)
    : board_(board),
      module_(board.graph.modules()[module]),
      index_(module),
      code_(board.graph, module),
      latch_(board.graph.segment()),
      inputs_(module_.topic.size()),
      sources_(module_.topic.size()),
      drops_(module_.topic.size()),
      enabled_(module_.spec.enabled) {
  if (board.options.clock) zones_.emplace(board.timeline.ring(module_.thread), *board.options.clock, module);
  record_.module = module;
  record_.thread = module_.thread;
  record_.ports = this;
  stats_.stopped.set(enabled_ ? 0 : 1);
  bind();
}

ModuleRunner::~ModuleRunner() {
  if (!module_.driver) return;
  module_.driver->end();
  for (const auto& raw : raws_)
    if (raw->held(0) != 0) bug("still holds slots of its raw topic after end()", module_.spec.name);
}

void ModuleRunner::bind() {
  Graph& graph = board_.graph;
  const WriterId writer = graph.output_writer(index_);
  if (writer != kNone) outputs_ = std::make_unique<Commit>(graph.segment(), writer);
  topic_of_id_.assign(graph.topics().size(), kNone);
  std::uint32_t output = 0;
  for (std::uint32_t p = 0; p < module_.topic.size(); ++p) {
    const Declaration::Port& port = module_.declaration.ports[p];
    if (module_.topic[p] == kNone) continue;
    if (port.kind == PortKind::output) {
      sources_[p] = {outputs_.get(), output};
      outputs_->bind(*port.output, output++);
    }
    if (port.kind == PortKind::raw) {
      raws_.push_back(std::make_unique<Commit>(graph.segment(), graph.raw_writer(index_, p)));
      raws_.back()->bind(*port.output, 0);
      sources_[p] = {raws_.back().get(), 0};
    }
    if (port.kind == PortKind::output || port.kind == PortKind::raw) {
      topic_of_id_[graph.topic_id(module_.topic[p])] = module_.topic[p];
      wakes_outsiders_ |= graph.bells() && graph.topics()[module_.topic[p]].wake_outsiders;
    }
    if (port.kind != PortKind::output) {
      inputs_[p] = port.input;
      latch_.bind(*port.input, graph.connection(index_, p), port.max_age, module_.carried_chains[p], port.expires);
    }
  }
  if (module_.external) module_.external->bound();
  published_.reserve(module_.topic.size());
}

std::span<const std::uint32_t> ModuleRunner::start(const Cycle& cycle, Time now) noexcept {
  published_.clear();
  stepping_ = runs();
  if (!stepping_) {
    if (module_.driver) module_.driver->rest(now);
    return {};
  }
  if (module_.driver) {
    module_.driver->collect(now);
    for (const auto& raw : raws_) publish(*raw, raw->commit({now}), now);
  }
  latch_.latch(now);
  for (std::size_t p = 0; p < inputs_.size(); ++p)
    if (inputs_[p] && inputs_[p]->dropped()) drops_[p].add(inputs_[p]->dropped());

  record_.number = number_++;
  record_.release = cycle.release;
  record_.now = now;
  record_.dt = cycle.dt;
  record_.timed_out = cycle.timed_out;
  record_.device_state = module_.driver ? module_.driver->device_state() : 0;
  ZoneLog* const zones = zones_ && board_.zones.load(std::memory_order_relaxed) ? &*zones_ : nullptr;
  record_.status = code_.run({now, cycle.dt, cycle.timed_out, record_.number}, zones);
  if (code_.changed_fp_mode()) stats_.fp_mode_changes.add();
  return published_;
}

std::span<const std::uint32_t> ModuleRunner::complete(Time now, Duration exec) noexcept {
  published_.clear();
  if (!stepping_) return {};
  stepping_ = false;
  if (record_.status == StepStatus::ok) {
    if (outputs_) {
      CommitInfo info{now};
      latch_.merge_origins(info.origin_ns);
      publish(*outputs_, outputs_->commit(info), now);
    }
    if (module_.driver) module_.driver->emit(now);
  } else if (outputs_) {
    outputs_->discard();
  }
  record_.completed = now;
  record_.exec = exec;
  stats_.exec.add(exec);
  board_.timeline.ring(module_.thread).add(TimelineEvent::Kind::step, record_.now, now - record_.now, module_.position);
  judge();
  if (board_.options.observer) board_.options.observer->completed(record_);
  latch_.release();
  return published_;
}

std::span<const SlotHeader* const> ModuleRunner::published(std::uint32_t port) const noexcept {
  const Source& source = sources_[port];
  return source.commit ? source.commit->committed(source.output) : std::span<const SlotHeader* const>();
}

std::size_t ModuleRunner::state_bytes() const noexcept { return SavedState(module_.declaration).bytes(); }
void ModuleRunner::save_state(std::span<std::byte> to) const noexcept { SavedState(module_.declaration).save(to); }

/// Counts what a commit made visible, and remembers its topics for the executor.
void ModuleRunner::publish(Commit& commit, std::uint32_t outputs, Time now) noexcept {
  if (wakes_outsiders_) wake_outsiders(commit, outputs);  // first: they wait for it, the counters do not
  for (std::uint32_t bits = outputs; bits; bits &= bits - 1) {
    const auto output = static_cast<std::uint32_t>(std::countr_zero(bits));
    const std::uint32_t topic = topic_of_id_[commit.topic(output)];
    const GraphTopic& about = board_.graph.topics()[topic];
    TopicStats& stats = board_.topics[topic];
    for (const SlotHeader* slot : commit.committed(output)) {
      stats.messages.add();
      stats.last_stamp_ns.set(slot->stamp.ns);
      stats.last_published_ns.set(now.ns);
      if (slot->stamp != Time{}) stats.age.add(now - slot->stamp);  // 0: a device that has measured nothing yet
      if (board_.options.hash_topics) msg::add_to_hash(board_.hashes[topic], *about.type, slot->message());
      for (std::uint32_t chains = about.sink_chains; chains; chains &= chains - 1) {
        const auto c = static_cast<std::uint32_t>(std::countr_zero(chains));
        if (slot->origin_ns[c] == kNoOrigin.ns) continue;
        const Duration age = now - Time{slot->origin_ns[c]}, budget = board_.graph.chains()[c].spec.budget;
        board_.chains[c].age.add(age);
        if (budget > Duration{0} && age > budget) board_.chains[c].budget_misses.add();
      }
    }
    published_.push_back(topic);
  }
}

void ModuleRunner::wake_outsiders(const Commit& commit, std::uint32_t outputs) noexcept {
  for (std::uint32_t bits = outputs; bits; bits &= bits - 1) {
    const TopicId id = commit.topic(static_cast<std::uint32_t>(std::countr_zero(bits)));
    if (!board_.graph.topics()[topic_of_id_[id]].wake_outsiders) continue;
    board_.graph.bells()->committed(board_.graph.segment().entry(id).writer, commit.number());
    return;  // one word for all outputs of a commit
  }
}

void ModuleRunner::judge() noexcept {
  stats_.steps.add();
  switch (record_.status) {
    case StepStatus::ok:
      stats_.ok.add();
      break;
    case StepStatus::stale:
      stats_.stale.add();
      break;
    case StepStatus::fault:
      stats_.fault.add();
      break;
  }
  stats_.best_effort_calls.set(code_.best_effort_calls());
  faults_in_row_ = record_.status == StepStatus::fault ? faults_in_row_ + 1 : 0;
  if (faults_in_row_ < board_.options.fault_limit || board_.options.fault_limit == 0) return;
  stopped_ = true;
  stats_.stops.add();
  stats_.stopped.set(1);
}

void ModuleRunner::set_enabled(bool enabled) noexcept {
  if (enabled && !runs()) {
    module_.module->reset();
    number_ = faults_in_row_ = 0;
    stopped_ = false;
  }
  enabled_ = enabled;
  stats_.stopped.set(runs() ? 0 : 1);
}

void ModuleRunner::set_param(const Request& request) noexcept {
  const Declaration::Param& p = module_.declaration.params[request.index];
  std::visit([&p](const auto value) { assign(p, ParamValue(value)); }, request.value);
}

}  // namespace sinew::rt
