#include "record/run/replay_subject.hpp"

#include <algorithm>

#include "msg/compare.hpp"
#include "record/run/verdict.hpp"

namespace sinew::record {
namespace {

using PortKind = rt::Declaration::PortKind;

const char* name_of(rt::Request::Kind kind) {
  using K = rt::Request::Kind;
  switch (kind) {
    case K::set_param:
      return "set_param";
    case K::enable:
      return "enable";
    case K::disable:
      return "disable";
    case K::set_period:
      return "set_period";
    case K::arm:
      return "arm";
    case K::disarm:
      return "disarm";
    case K::message:
      return "message";
  }
  return "?";
}

const char* name_of(rt::StepStatus status) {
  if (status == rt::StepStatus::ok) return "ok";
  return status == rt::StepStatus::stale ? "stale" : "fault";
}

std::string text(const rt::Effect& e) {
  return std::string(e.refused ? "refused before step " : "from step ") + std::to_string(e.step);
}

}  // namespace

ReplaySubject::ReplaySubject(rt::Graph& graph, std::uint32_t module, const RecordedRun& run, ReplayChain& chain,
                             const ReplayOptions& options)
    : about_(graph.modules()[module]),
      again_(graph, module),
      run_(run),
      chain_(chain),
      watcher_(options.watcher),
      goes_on_(options.chain || options.watcher != nullptr),
      inputs_(about_.topic.size()),
      held_(about_.topic.size()),
      last_(about_.topic.size()) {
  report.name = about_.spec.name;
  for (const auto& p : about_.declaration.params)
    kept_.push_back(std::find(options.keep.begin(), options.keep.end(), report.name + "." + p.name) !=
                    options.keep.end());
}

void ReplaySubject::begin_at(const LoggedState& state, std::uint64_t layout) {
  begin_ = state.order;
  begin_bytes_.assign(state.bytes.begin(), state.bytes.end());
  begin_layout_ = layout;
  report.from = state.completed;
}

void ReplaySubject::stop(std::string why) {
  if (runs()) report.stopped = std::move(why);
}

void ReplaySubject::step(const LoggedStep& s) {
  if (!runs() || waits(s.order) || !begun() || !hold(s)) return;
  if (about_.external && !post(s)) return;
  rt::StepRecord record;
  record.module = s.module, record.thread = s.thread, record.number = s.number;
  record.release = s.release, record.now = s.now, record.completed = s.completed;
  record.dt = s.dt, record.exec = s.exec, record.timed_out = s.timed_out, record.device_state = s.device_state;
  record.status = s.status;
  const auto status = again_.step(record, inputs_);
  if (!status) return stop("step " + std::to_string(s.number) + ": " + status.error().where);
  ++report.steps;
  if (*status != s.status) differs(s, "status", name_of(s.status), name_of(*status));
  for (std::uint32_t p = 0; p < about_.topic.size(); ++p)
    if (about_.declaration.ports[p].kind == PortKind::output && about_.topic[p] != rt::kNone) compare(s, p);
}

void ReplaySubject::request(const LoggedRequest& r) {
  using Kind = rt::Request::Kind;
  if (!runs() || r.request.kind == Kind::message) return;  // they come with their step
  const bool sets = r.request.kind == Kind::set_param;
  if (sets && r.request.index < kept_.size() && kept_[r.request.index]) {
    ++report.settings_ignored;
    return;
  }
  if (waits(r.order)) {
    if (sets && !again_.take(r.request, r.effect)) stop("set_param");
    return;
  }
  if (!begun()) return;
  const auto effect = again_.take(r.request, r.effect);
  if (!effect) return stop(std::string(name_of(r.request.kind)) + ": " + effect.error().where);
  if (*effect == r.effect) return;
  LoggedStep at;
  at.number = r.effect.step;
  at.now = r.now;
  differs(at, std::string("effect of ") + name_of(r.request.kind), text(r.effect), text(*effect));
}

/// False when the state to begin with does not fit.
bool ReplaySubject::begun() {
  if (!begin_) return true;
  const bool fits = begin_layout_ == again_.state_layout() && again_.restore_state(begin_bytes_);
  begin_.reset();
  if (!fits) stop("its state was saved by another version of the module or another kind of machine");
  return fits;
}

bool ReplaySubject::hold(const LoggedStep& s) {
  for (auto& input : inputs_) input = {};
  for (const LoggedStep::Input& in : s.inputs) {
    if (in.port >= about_.topic.size() || about_.topic[in.port] == rt::kNone) {
      stop("the record has an input that this module does not have");
      return false;
    }
    if (!hold(s, in)) return false;
  }
  for (const LoggedStep::Output& out : s.outputs)
    if (out.port >= about_.topic.size() || about_.topic[out.port] == rt::kNone) {
      stop("the record has an output that this module does not have");
      return false;
    }
  return true;
}

bool ReplaySubject::hold(const LoggedStep& s, const LoggedStep::Input& in) {
  const std::uint32_t topic = about_.topic[in.port];
  const bool latest = about_.declaration.ports[in.port].kind == PortKind::latest;
  std::vector<const rt::SlotHeader*>& held = held_[in.port];
  held.clear();
  bool updated = in.updated;
  for (const std::uint32_t sequence : in.sequences) {
    const auto source = chain_.source(topic, sequence);
    const auto message = [sequence] { return "message " + std::to_string(sequence); };
    if (source == ReplayChain::Source::nowhere) {
      missing(s, in.port, message() + " was not published again: its writer ended before");
      return false;
    }
    const MessageStore::Entry* entry = nullptr;
    if (source == ReplayChain::Source::now) {
      entry = latest ? chain_.store(topic).newest_until(sequence) : chain_.store(topic).find(sequence);
      if (!entry) continue;
    } else {
      entry = run_.messages(topic).find(sequence);
      if (!entry) {
        missing(s, in.port, message() + " is not in the file");
        return false;
      }
      if (!entry->whole) {
        missing(s, in.port, "the pixels of " + message() + " are not in the file");
        return false;
      }
    }
    if (source == ReplayChain::Source::now && entry->sequence != sequence) updated = last_[in.port] != entry->sequence;
    if (latest) last_[in.port] = entry->sequence;
    held.push_back(entry->header());
  }
  inputs_[in.port] = {held, updated && !(latest && held.empty()), in.dropped};
  return true;
}

void ReplaySubject::missing(const LoggedStep& s, std::uint32_t port, const std::string& what) {
  stop("at " + seconds_text(s.now) + ": input " + about_.declaration.ports[port].name + ": " + what);
}

/// Messages from outside are in the file as the source published them.
bool ReplaySubject::post(const LoggedStep& s) {
  for (const LoggedStep::Output& out : s.outputs)
    for (std::uint32_t i = 0; i < out.count; ++i) {
      const MessageStore& store = run_.messages(about_.topic[out.port]);
      const MessageStore::Entry* entry = store.find(out.first + i);
      if (!entry) {
        stop("a message from outside is not in the file");
        return false;
      }
      rt::Request request;
      request.kind = rt::Request::Kind::message;
      request.index = out.port;
      if (!entry->whole) {
        stop("the pixels of a message from outside are not in the file");
        return false;
      }
      const std::size_t pixels = store.type().has_bulk() ? store.type().bulk_used(entry->message()) : 0;
      const std::span message(static_cast<const std::byte*>(entry->message()), store.type().size + pixels);
      if (auto taken = again_.take(request, {s.number, false}, message); !taken) {
        stop(std::string("message: ") + taken.error().where);
        return false;
      }
    }
  return true;
}

void ReplaySubject::compare(const LoggedStep& s, std::uint32_t port) {
  const auto published = again_.published(port);
  const auto out = std::find_if(s.outputs.begin(), s.outputs.end(), [&](const auto& o) { return o.port == port; });
  const std::uint32_t count = out == s.outputs.end() ? 0 : out->count;
  const std::uint32_t first = count == 0 ? 0 : out->first;
  if (const std::uint32_t topic = about_.topic[port]; count != 0 && chain_.begins(topic))
    chain_.begin(topic, run_.messages(topic).newest_until(first - 1));
  chain_.publish(about_.topic[port], first, count, published);
  if (!runs()) return;
  if (published.size() != count)
    differs(s, "messages on " + about_.declaration.ports[port].name, std::to_string(count),
            std::to_string(published.size()));
  if (published.size() < count) report.missing += count - published.size();
  if (published.size() > count) report.extra += published.size() - count;
  const std::uint32_t both = std::min(count, static_cast<std::uint32_t>(published.size()));
  for (std::uint32_t i = 0; i < both && runs(); ++i) compare(s, port, first + i, *published[i]);
}

void ReplaySubject::compare(const LoggedStep& s, std::uint32_t port, std::uint32_t sequence,
                            const rt::SlotHeader& again) {
  const std::uint32_t topic = about_.topic[port];
  const MessageStore::Entry* const recorded = run_.messages(topic).find(sequence);
  if (!recorded || !recorded->whole) {
    ++report.not_compared;
    return;
  }
  ++report.messages;
  if (watcher_) watcher_->compared({topic, s.now, *recorded->header(), again});
  const msg::TypeInfo& type = run_.messages(topic).type();
  if (msg::equal(type, recorded->message(), again.message())) return;
  ++report.differing;
  if (report.difference) return;
  const auto d = msg::first_difference(type, recorded->message(), again.message());
  differs(s, about_.declaration.ports[port].name + "." + d->path, d->a, d->b);
}

void ReplaySubject::differs(const LoggedStep& s, std::string what, std::string recorded, std::string again) {
  if (!report.difference)
    report.difference =
        ReplayDifference{report.name, s.number, s.now, std::move(what), std::move(recorded), std::move(again)};
}

}  // namespace sinew::record
