#pragma once
// A recorder for tests: keeps every step, message, request and some saved states of a run in memory, and executes them
// again.
#include <cstring>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "hal/silent_board.hpp"
#include "msg/compare.hpp"
#include "rt/exec/step_again.hpp"
#include "rt/external_source.hpp"

namespace sinew::rt {

/// One message as it was in its slot: header, struct, used bulk.
class KeptMessage {
 public:
  KeptMessage(const SlotHeader& slot, const msg::TypeInfo& type) {
    const std::size_t size = sizeof(SlotHeader) + type.size + msg::bulk_of(type, slot.message()).size();
    bytes_.reset(static_cast<std::byte*>(::operator new (size, std::align_val_t{alignof(SlotHeader)})));
    std::memcpy(bytes_.get(), &slot, size);
  }
  SlotHeader* header() { return reinterpret_cast<SlotHeader*>(bytes_.get()); }

 private:
  struct Free {
    void operator()(std::byte* p) const { ::operator delete (p, std::align_val_t{alignof(SlotHeader)}); }
  };
  std::unique_ptr<std::byte, Free> bytes_;
};

/// A request or a step of one module.
struct KeptEntry {
  struct Port {
    std::vector<const SlotHeader*> messages;
    bool updated = false;
    std::uint32_t dropped = 0;
  };
  std::optional<Request> request;
  Effect effect{};
  std::vector<std::byte> message;  // of a request for an external topic

  StepRecord step;
  std::vector<Port> in;
  std::vector<std::vector<const SlotHeader*>> out;  // outputs alone
  std::optional<std::vector<std::byte>> state;      // after the step, when it was saved
};

/// Thread:  completed(), taken(): any; the rest while the run stands still.
class MemoryRecord final : public RunObserver {
 public:
  MemoryRecord(const Graph& graph, Duration save_every)
      : graph_(graph), save_every_(save_every), modules_(graph.modules().size()), next_save_(modules_.size()) {}

  void completed(const StepRecord& record) noexcept override {
    const std::lock_guard lock(mutex_);
    const GraphModule& about = graph_.modules()[record.module];
    KeptEntry e;
    e.step = record;
    e.step.ports = nullptr;
    e.in.resize(about.topic.size());
    e.out.resize(about.topic.size());
    for (std::uint32_t p = 0; p < about.topic.size(); ++p) {
      if (const InputBase* in = record.ports->input(p)) {
        for (std::size_t i = 0; i < in->size(); ++i) e.in[p].messages.push_back(keep(about.topic[p], in->header(i)));
        e.in[p].updated = in->updated();
        e.in[p].dropped = in->dropped();
      } else {
        for (const SlotHeader* h : record.ports->published(p)) e.out[p].push_back(keep(about.topic[p], h));
      }
    }
    if (record.completed >= next_save_[record.module]) {
      next_save_[record.module] = record.completed + save_every_;
      e.state.emplace(record.ports->state_bytes());
      record.ports->save_state(*e.state);
    }
    modules_[record.module].push_back(std::move(e));
  }
  void taken(const Request& request, const Effect& effect, Time) noexcept override {
    if (request.kind == Request::Kind::set_period) return;  // of the thread
    const std::lock_guard lock(mutex_);
    KeptEntry e;
    e.request = request;
    e.effect = effect;
    if (request.kind == Request::Kind::message) {
      const ExternalSource& source = *graph_.modules()[request.module].external;
      const auto message = source.message_of(request.index);
      e.message.assign(message.begin(), message.end());
      e.request->index = source.port_of(request.index);
    }
    modules_[request.module].push_back(std::move(e));
  }

  std::vector<KeptEntry>& of(std::uint32_t module) { return modules_[module]; }
  std::size_t steps(std::uint32_t module) const {
    std::size_t n = 0;
    for (const KeptEntry& e : modules_[module]) n += e.request ? 0 : 1;
    return n;
  }
  /// The entries after which a state was saved.
  std::vector<std::size_t> saved(std::uint32_t module) const {
    std::vector<std::size_t> all;
    for (std::size_t i = 0; i < modules_[module].size(); ++i)
      if (modules_[module][i].state) all.push_back(i);
    return all;
  }

 private:
  const SlotHeader* keep(std::uint32_t topic, const SlotHeader* slot) {
    auto& kept = messages_[{topic, slot->sequence}];
    if (!kept) kept = std::make_unique<KeptMessage>(*slot, *graph_.topics()[topic].type);
    return kept->header();
  }
  std::mutex mutex_;
  const Graph& graph_;
  const Duration save_every_;
  std::vector<std::vector<KeptEntry>> modules_;
  std::vector<Time> next_save_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::unique_ptr<KeptMessage>> messages_;  // topic, sequence
};

/// Where a module did something else than recorded.
struct Departure {
  std::size_t entry = 0;
  std::string what;
};

/// Executes a record of the same robot again, in a graph of its own.
class RunAgain {
 public:
  RunAgain(const GraphSpec& spec, const ModuleTypes& types) : graph_(spec, types) {
    configured_ = bool(graph_.configure(board_));
    for (std::uint32_t m = 0; m < graph_.modules().size(); ++m)
      modules_.push_back(std::make_unique<StepAgain>(graph_, m));
  }
  bool configured() const { return configured_; }
  const Graph& graph() const { return graph_; }
  StepAgain& module(std::uint32_t m) { return *modules_[m]; }

  /// Entries [begin, end) of a module; nothing when all was as recorded. A begin other than 0 must be right behind a
  /// saved state.
  std::optional<Departure> run(std::uint32_t module, const std::vector<KeptEntry>& entries, std::size_t begin,
                               std::size_t end) {
    if (begin != 0) {
      for (std::size_t i = 0; i < begin; ++i)
        if (entries[i].request && entries[i].request->kind == Request::Kind::set_param)
          if (!modules_[module]->take(*entries[i].request, entries[i].effect)) return Departure{i, "refused"};
      if (!modules_[module]->restore_state(*entries[begin - 1].state)) return Departure{begin - 1, "state refused"};
    }
    for (std::size_t i = begin; i < std::min(end, entries.size()); ++i)
      if (std::string what = entry(module, entries[i]); !what.empty()) return Departure{i, std::move(what)};
    return std::nullopt;
  }

 private:
  std::string entry(std::uint32_t module, const KeptEntry& e) {
    StepAgain& again = *modules_[module];
    if (e.request) {
      const auto effect = again.take(*e.request, e.effect, e.message);
      return effect && *effect == e.effect ? "" : "another effect of a request";
    }
    std::vector<StepAgain::Input> in;
    for (const KeptEntry::Port& p : e.in) in.push_back({p.messages, p.updated, p.dropped});
    const auto status = again.step(e.step, in);
    if (!status) return status.error().where;
    if (*status != e.step.status) return "status";
    for (std::uint32_t p = 0; p < e.out.size(); ++p)
      if (std::string what = port(module, p, e.out[p], again.published(p)); !what.empty()) return what;
    return "";
  }
  std::string port(std::uint32_t module, std::uint32_t p, std::span<const SlotHeader* const> then,
                   std::span<const SlotHeader* const> now) const {
    const Declaration::Port& port = graph_.modules()[module].declaration.ports[p];
    if (port.kind == Declaration::PortKind::raw) return "";
    if (then.size() != now.size()) return port.name + ": number of messages";
    for (std::size_t i = 0; i < then.size(); ++i) {
      if (const auto d = msg::first_difference(*port.type, then[i]->message(), now[i]->message()))
        return port.name + "." + d->path;
      if (then[i]->stamp != now[i]->stamp || then[i]->published != now[i]->published) return port.name + ": instants";
      for (std::size_t c = 0; c < kMaxChains; ++c)
        if (then[i]->origin_ns[c] != now[i]->origin_ns[c]) return port.name + ": origin";
    }
    return "";
  }

  hal::SilentBoard board_;
  Graph graph_;
  bool configured_ = false;
  std::vector<std::unique_ptr<StepAgain>> modules_;
};

/// Whether a saved state shows a difference when one of a module's members of state, by its place in the declaration,
/// keeps its configured value, as if it had not been declared.
inline bool forgetting_is_noticed(const GraphSpec& spec, const ModuleTypes& types, MemoryRecord& record,
                                  std::uint32_t module, std::size_t member) {
  std::vector<KeptEntry>& all = record.of(module);
  for (const std::size_t at : record.saved(module)) {
    RunAgain again(spec, types);
    const Declaration& d = again.graph().modules()[module].declaration;
    const auto size = [&d](std::size_t i) { return d.states[i].bytes(d.states[i].member).size(); };
    std::size_t offset = 0;
    for (const auto& port : d.ports) offset += port.input ? sizeof(std::uint64_t) : 0;
    for (std::size_t i = 0; i < member; ++i) offset += size(i);
    std::vector<std::byte> fresh(again.module(module).state_bytes());
    again.module(module).save_state(fresh);
    const std::vector<std::byte> right = *all[at].state;
    if (size(member) != 0) std::memcpy(all[at].state->data() + offset, fresh.data() + offset, size(member));
    const auto departure = again.run(module, all, at + 1, all.size());
    *all[at].state = right;
    if (departure) return true;
  }
  return false;
}

}  // namespace sinew::rt
