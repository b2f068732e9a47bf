#include "record/run/step_log.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

#include "rt/saved_state.hpp"

namespace sinew::record {
namespace {

using PortKind = rt::Declaration::PortKind;

// Entries are words: the first word holds the number of words, then come this kind and the variable part.
enum class EntryKind : std::uint32_t { skip, step, request, state };

struct Head {
  std::uint32_t words;
  EntryKind kind;
  std::uint32_t lost;  // entries before this one
  std::uint32_t unused = 0;
};
struct StepHead {
  Head head;
  std::uint32_t module, number, device_state;
  std::uint8_t status, timed_out, unused[2] = {};
  std::int64_t release_ns, now_ns, completed_ns, dt_ns, exec_ns;
};
struct RequestEntry {
  Head head;
  rt::Request request;
  rt::Effect effect;
  rt::Time now;
};
struct StateEntry {  // its bytes lie elsewhere
  Head head;
  std::uint32_t module, number;
  rt::Time completed;
};
static_assert(std::is_trivially_copyable_v<rt::Request>);

template <class T>
constexpr std::uint32_t words_of() {
  return (sizeof(T) + 3) / 4;
}

template <class T>
std::uint32_t* put(std::uint32_t* to, const T& value) {
  std::memcpy(to, &value, sizeof value);
  return to + words_of<T>();
}
template <class T>
const std::uint32_t* get(const std::uint32_t* from, T& value) {
  std::memcpy(static_cast<void*>(&value), from, sizeof value);
  return from + words_of<T>();
}

/// A device thread has no known rate: takes that of a fast camera.
double cycles_per_s(const rt::Graph& graph, const rt::GraphThread& thread) {
  constexpr double kDevice_hz = 100;
  if (thread.spec.period.count() > 0) return 1 / msg::seconds(thread.spec.period);
  double most_hz = 0;
  for (std::uint32_t topic = 0; topic < graph.topics().size(); ++topic) {
    const std::uint32_t writer = graph.topics()[topic].writer;
    const bool ours = std::find(thread.modules.begin(), thread.modules.end(), writer) != thread.modules.end();
    if (ours) most_hz = std::max(most_hz, graph.planned_rate_hz(topic));
  }
  return most_hz > 0 ? most_hz : kDevice_hz;
}

constexpr std::uint32_t kUpdated = 0x80000000, kList = 0x40000000, kCount = 0x3FFFFFFF;

}  // namespace

/// For one module: which ports to log, and the largest size of its entries.
struct StepLog::Ports {
  struct Input {
    std::uint32_t port;
    bool gaps;  // drop_newest: sequences may be missing in between
  };
  std::vector<Input> inputs;
  std::vector<std::uint32_t> outputs;
  std::uint32_t words = 0;

  Ports(const rt::GraphModule& module, std::uint32_t chains) {
    words = words_of<StepHead>() + 1;
    for (std::uint32_t p = 0; p < module.topic.size(); ++p) {
      const auto& port = module.declaration.ports[p];
      if (module.topic[p] == rt::kNone) continue;
      const bool input = port.kind != PortKind::output,
                 output = port.kind != PortKind::latest && port.kind != PortKind::queue;
      if (input) {
        inputs.push_back({p, port.overflow == rt::Overflow::drop_newest && port.kind == PortKind::queue});
        words += 2 + (inputs.back().gaps ? port.depth : 1);
      }
      if (output) {
        outputs.push_back(p);
        words += 3 + 2 * chains;
      }
    }
  }
};

/// The saved state of one module on its way: the executor fills it while it is empty, the reader empties it.
struct StepLog::State {
  explicit State(std::size_t size) : bytes(size) {}
  std::vector<std::byte> bytes;
  std::atomic<bool> full{false};   // release by the giving side, acquire by the other
  std::atomic<bool> asked{false};  // by the reader; orders nothing
  rt::Time next{INT64_MIN};        // of the executor
};

// Room that steps leave for requests: a lost step costs only that step, a lost parameter all later steps.
constexpr std::uint32_t kRequests = 8;

/// Words from one writer to one reader. Positions count words and wrap around where they have 32 bits; an entry never
/// wraps around the end.
class StepLog::Ring {
 public:
  using Position = std::size_t;  // a size that every machine reads at once

  explicit Ring(std::size_t words) : words_(std::bit_ceil(words)), ring_(std::make_unique<std::uint32_t[]>(words_)) {
    std::memset(ring_.get(), 0, words_ * sizeof(std::uint32_t));  // so that its pages are there before the run
  }

  /// Writer: room for so many words in a row, and `spare` behind them; null when there is none.
  std::uint32_t* reserve(std::uint32_t words, std::uint32_t spare = 0) noexcept {
    const std::size_t at = written_ & (words_ - 1), to_end = words_ - at;
    const std::size_t skip = words <= to_end ? 0 : to_end;
    // acquire: the reader has finished with what it left
    if (written_ + skip + words + spare - tail_.load(std::memory_order_acquire) > words_) return nullptr;
    if (skip != 0) {
      ring_[at] = 0;  // the rest is empty
      written_ += skip;
    }
    return &ring_[written_ & (words_ - 1)];
  }
  void publish(std::uint32_t* entry, const std::uint32_t* end) noexcept {
    entry[0] = static_cast<std::uint32_t>(end - entry);
    written_ += entry[0];
    lost_ = 0;
    head_.store(written_, std::memory_order_release);  // partner: next()
  }
  void lose() noexcept { ++lost_; }
  std::uint32_t lost() const noexcept { return lost_; }

  /// Reader: everything up to here may be read.
  Position there() const noexcept { return head_.load(std::memory_order_acquire); }
  bool has_read(Position up_to) const noexcept { return static_cast<std::ptrdiff_t>(read_ - up_to) >= 0; }
  /// Reader: the next entry, null when there is none; then pop().
  const std::uint32_t* next() noexcept {
    const Position head = head_.load(std::memory_order_acquire);
    if (read_ == head) return nullptr;
    if (ring_[read_ & (words_ - 1)] == 0) read_ += words_ - (read_ & (words_ - 1));
    return &ring_[read_ & (words_ - 1)];
  }
  void pop(const std::uint32_t* entry) noexcept {
    read_ += entry[0];
    tail_.store(read_, std::memory_order_release);
  }

 private:
  const std::size_t words_;
  const std::unique_ptr<std::uint32_t[]> ring_;
  Position written_ = 0;    // the writer's
  std::uint32_t lost_ = 0;  // since the last entry; the writer's, read by others only after the run
  std::atomic<Position> head_{0};
  alignas(64) std::atomic<Position> tail_{0};
  Position read_ = 0;  // the reader's
};

StepLog::StepLog(const rt::Graph& graph, rt::Duration room, rt::Duration state_every)
    : chains_(static_cast<std::uint32_t>(graph.chains().size())),
      state_every_(state_every),
      order_(graph.threads().size()) {
  for (const rt::GraphModule& m : graph.modules()) {
    ports_.emplace_back(m, chains_);
    states_.push_back(std::make_unique<State>(rt::SavedState(m.declaration).bytes()));
  }
  for (const rt::GraphThread& t : graph.threads()) {
    std::size_t cycle = 0, largest = std::max(words_of<RequestEntry>(), words_of<StateEntry>());
    for (const std::uint32_t m : t.modules) {
      cycle += ports_[m].words;
      largest = std::max<std::size_t>(largest, ports_[m].words);
    }
    const auto cycles = static_cast<std::size_t>(cycles_per_s(graph, t) * msg::seconds(room));
    rings_.push_back(std::make_unique<Ring>(std::max(cycles * cycle, 8 * largest)));
  }
}

StepLog::~StepLog() = default;

void StepLog::completed(const rt::StepRecord& r) noexcept {
  Ring& ring = *rings_[r.thread];
  const Ports& ports = ports_[r.module];
  std::uint32_t* const entry = ring.reserve(ports.words, kRequests * words_of<RequestEntry>());
  if (!entry) return ring.lose();
  const StepHead head{{0, EntryKind::step, ring.lost()},
                      r.module,
                      r.number,
                      r.device_state,
                      static_cast<std::uint8_t>(r.status),
                      r.timed_out,
                      {},
                      r.release.ns,
                      r.now.ns,
                      r.completed.ns,
                      r.dt.count(),
                      r.exec.count()};
  std::uint32_t* to = put(entry, head);
  to = put_inputs(r, ports, to);
  ring.publish(entry, put_outputs(r, ports, to));
  tell_state(r);
}

void StepLog::ask_state(std::uint32_t module) noexcept {
  states_[module]->asked.store(true, std::memory_order_relaxed);
}

void StepLog::tell_state(const rt::StepRecord& r) noexcept {
  State& state = *states_[r.module];
  const bool asked = state.asked.load(std::memory_order_relaxed);
  if ((r.completed < state.next && !asked) || state.full.load(std::memory_order_acquire)) return;
  const bool first = state.next.ns == INT64_MIN;
  if (state_every_ <= rt::Duration{0})
    state.next = rt::Time{INT64_MAX};
  else if (first)  // so that modules do not save in the same cycle
    state.next = r.completed +
                 state_every_ * (static_cast<std::int64_t>(r.module) + 1) / static_cast<std::int64_t>(states_.size());
  else
    state.next = r.completed + state_every_;
  if (first && !asked) return;
  Ring& ring = *rings_[r.thread];
  std::uint32_t* const entry = ring.reserve(words_of<StateEntry>(), kRequests * words_of<RequestEntry>());
  if (!entry) return;  // one place less to begin at, and nothing lost
  state.asked.store(false, std::memory_order_relaxed);
  r.ports->save_state(state.bytes);
  state.full.store(true, std::memory_order_release);
  ring.publish(entry, put(entry, StateEntry{{0, EntryKind::state, ring.lost()}, r.module, r.number, r.completed}));
}

std::uint32_t* StepLog::put_inputs(const rt::StepRecord& r, const Ports& ports, std::uint32_t* to) const noexcept {
  for (const Ports::Input& in : ports.inputs) {
    const rt::InputBase& input = *r.ports->input(in.port);
    const auto count = static_cast<std::uint32_t>(input.size());
    *to++ = count | (input.updated() ? kUpdated : 0) | (in.gaps ? kList : 0);
    *to++ = input.dropped();
    for (std::uint32_t i = 0; i < (in.gaps ? count : std::min(count, 1u)); ++i) *to++ = input.header(i)->sequence;
  }
  return to;
}

std::uint32_t* StepLog::put_outputs(const rt::StepRecord& r, const Ports& ports, std::uint32_t* to) const noexcept {
  std::uint32_t* const number = to++;
  *number = 0;
  for (const std::uint32_t port : ports.outputs) {
    const auto messages = r.ports->published(port);
    if (messages.empty()) continue;
    ++*number;
    *to++ = port;
    *to++ = messages.front()->sequence;
    *to++ = static_cast<std::uint32_t>(messages.size());
    std::memcpy(to, messages.front()->origin_ns, chains_ * sizeof(std::int64_t));
    to += chains_ * 2;
  }
  return to;
}

void StepLog::taken(const rt::Request& request, const rt::Effect& effect, rt::Time now) noexcept {
  Ring& ring = *rings_[request.thread];
  std::uint32_t* const entry = ring.reserve(words_of<RequestEntry>());
  if (!entry) return ring.lose();
  ring.publish(entry, put(entry, RequestEntry{{0, EntryKind::request, ring.lost()}, request, effect, now}));
}

namespace {

/// When the step or request of an entry was over.
rt::Time over(const std::uint32_t* words, EntryKind kind) {
  if (kind == EntryKind::step) {
    StepHead step;
    get(words, step);
    return {step.completed_ns};
  }
  if (kind == EntryKind::state) {
    StateEntry state;
    get(words, state);
    return state.completed;
  }
  RequestEntry request;
  get(words, request);
  return request.now;
}

}  // namespace

void StepLog::read(std::uint32_t thread, Visitor& visitor, bool last, rt::Time until) {
  Ring& ring = *rings_[thread];
  std::uint64_t& order = order_[thread];
  const Ring::Position there = ring.there();  // fixed now: the other threads' rings fill, too
  while (!ring.has_read(there)) {
    const std::uint32_t* words = ring.next();
    Head head;
    get(words, head);
    if (over(words, head.kind) > until) break;
    if (head.lost != 0) visitor.lost(thread, head.lost);
    order += head.lost;
    if (head.kind == EntryKind::step) {
      read_step(thread, words);
      step_.order = order++;
      ring.pop(words);
      visitor.step(step_);
    } else if (head.kind == EntryKind::state) {
      StateEntry entry;
      get(words, entry);
      ring.pop(words);
      State& state = *states_[entry.module];
      visitor.state({order++, thread, entry.module, entry.number, entry.completed, state.bytes});
      state.full.store(false, std::memory_order_release);
    } else {
      RequestEntry entry;
      get(words, entry);
      ring.pop(words);
      visitor.request({order++, entry.request, entry.effect, entry.now});
    }
  }
  if (last && ring.lost() != 0) visitor.lost(thread, ring.lost());
}

void StepLog::read_step(std::uint32_t thread, const std::uint32_t* words) {
  StepHead head;
  words = get(words, head);
  const Ports& ports = ports_[head.module];
  step_.thread = thread;
  step_.module = head.module;
  step_.number = head.number;
  step_.device_state = head.device_state;
  step_.release = {head.release_ns}, step_.now = {head.now_ns}, step_.completed = {head.completed_ns};
  step_.dt = rt::Duration{head.dt_ns}, step_.exec = rt::Duration{head.exec_ns};
  step_.status = static_cast<rt::StepStatus>(head.status);
  step_.timed_out = head.timed_out != 0;
  step_.inputs.resize(ports.inputs.size());
  for (std::size_t i = 0; i < ports.inputs.size(); ++i) {
    LoggedStep::Input& input = step_.inputs[i];
    const std::uint32_t word = *words++, count = word & kCount;
    input.port = ports.inputs[i].port;
    input.updated = (word & kUpdated) != 0;
    input.dropped = *words++;
    input.sequences.resize(count);
    for (std::uint32_t k = 0; k < count; ++k) input.sequences[k] = (word & kList) != 0 ? words[k] : words[0] + k;
    words += (word & kList) != 0 ? count : std::min(count, 1u);
  }
  step_.outputs.resize(*words++);
  for (LoggedStep::Output& output : step_.outputs) {
    output.port = *words++;
    output.first = *words++;
    output.count = *words++;
    output.origin_ns.resize(chains_);
    if (chains_ != 0) std::memcpy(output.origin_ns.data(), words, chains_ * sizeof(std::int64_t));
    words += chains_ * 2;
  }
}

}  // namespace sinew::record
