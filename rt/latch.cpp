#include "rt/latch.hpp"

#include <algorithm>
#include <bit>

namespace sinew::rt {

struct Latch::Port {
  InputBase* input;
  TopicRing<StdAtomics> ring;
  const std::byte* slots;
  std::size_t stride;
  std::uint32_t output, depth;
  std::uint32_t carried_chains;
  ConnectionPlan::Kind kind;
  bool pins;               // false: writer and reader never run at the same time
  std::uint32_t last = 0;  // sequence of the topic in the latched commit
  std::uint32_t before;    // queue: last sequence consumed; latest: sequence held by the previous step
  Segment::Queue* queue;   // drop_newest
  std::unique_ptr<const SlotHeader*[]> held;
  std::unique_ptr<std::uint32_t[]> held_slot;

  const SlotHeader* slot(std::uint32_t i) const { return reinterpret_cast<const SlotHeader*>(slots + i * stride); }
  bool take_latest() noexcept;
  bool take_queue() noexcept;
  void undo() noexcept;
};

struct Latch::Group {
  WriterId writer;
  CommitLog<StdAtomics> log;
  std::vector<Port> ports;

  bool take() noexcept;
};

/// The writer is in our thread and stands still, so its newest messages are of one commit, and cannot go away.
struct Latch::Near {
  InputBase* input;
  const SlotHeader* const* newest;
  std::unique_ptr<const SlotHeader*> held;
  std::uint32_t carried_chains;
  std::uint32_t before;  // sequence held by the previous step

  void take() noexcept {
    const SlotHeader* header = *newest;
    if (!header) return;
    const std::uint32_t sequence = header->sequence;
    InputBase& in = *input;
    *held = header;
    in.count_ = 1;
    in.updated_ = sequence != before;
    before = sequence;
  }
};

void InputBase::merge_origins(std::uint32_t carried_chains, std::int64_t (&oldest_ns)[kMaxChains]) const noexcept {
  for (std::uint32_t chains = count_ ? carried_chains : 0; chains; chains &= chains - 1) {
    const int c = std::countr_zero(chains);
    for (std::uint32_t i = 0; i < count_; ++i) oldest_ns[c] = std::min(oldest_ns[c], slots_[i]->origin_ns[c]);
  }
}

Latch::Latch(Segment& segment) : segment_(segment) {}
Latch::~Latch() = default;

void Latch::bind(InputBase& input, ConnectionId id, Duration max_age, std::uint32_t carried_chains, Duration expires) {
  const Segment::Connection& c = segment_.connections_[id];
  const TopicEntry& entry = segment_.entry(c.topic);
  const std::uint32_t sequence_before = segment_.header().first_sequence - 1;
  carried_chains &= (1U << kMaxChains) - 1;
  input.max_age_ = max_age;
  if (expires != Duration{INT64_MAX}) expiring_.push_back({&input, expires});
  if (c.plan.kind == ConnectionPlan::Kind::latest && c.plan.same_thread) {
    near_.push_back({&input, &segment_.topics_[c.topic].newest, std::make_unique<const SlotHeader*>(nullptr),
                     carried_chains, sequence_before});
    input.slots_ = near_.back().held.get();
    return;
  }
  auto group = std::find_if(groups_.begin(), groups_.end(), [&](const Group& g) { return g.writer == entry.writer; });
  if (group == groups_.end()) group = groups_.insert(group, Group{entry.writer, segment_.log(entry.writer), {}});

  Port port{};
  port.input = &input;
  port.ring = segment_.ring(c.topic);
  port.slots = &segment_.at<std::byte>(entry.slots);
  port.stride = static_cast<std::size_t>(entry.slot_stride);
  port.output = entry.output;
  port.depth = c.plan.depth;
  port.carried_chains = carried_chains;
  port.kind = c.plan.kind;
  port.pins = !c.plan.same_thread;
  port.before = sequence_before;
  port.queue = c.queue ? &c.queue->queue : nullptr;
  port.held = std::make_unique<const SlotHeader*[]>(port.depth);
  port.held_slot = std::make_unique<std::uint32_t[]>(port.depth);
  input.slots_ = port.held.get();
  group->ports.push_back(std::move(port));
}

inline bool Latch::Port::take_latest() noexcept {
  std::uint32_t got = 0;
  if (!ring.pin(
          last, 1, [this](std::uint32_t s) { return slot(s)->sequence; }, held_slot.get(), got))
    return false;
  if (got) held[0] = slot(held_slot[0]);
  input->count_ = got;
  input->updated_ = last != before;  // before the first message both are the sequence before it
  return true;
}

bool Latch::Port::take_queue() noexcept {
  const std::uint32_t fresh = last - before, wanted = std::min(fresh, depth);
  const auto sequence_in = [this](std::uint32_t s) { return slot(s)->sequence; };
  std::uint32_t got = wanted;
  if (queue) {  // pinned by the writer
    got = queue->take(last, sequence_in, held_slot.get());
  } else if (pins) {
    if (!ring.pin(last, wanted, sequence_in, held_slot.get(), got)) return false;
  } else {
    for (std::uint32_t i = 0; i < wanted; ++i) held_slot[i] = ring.slot_of(last - (wanted - 1 - i));
  }
  for (std::uint32_t i = 0; i < got; ++i) held[i] = slot(held_slot[i]);
  input->count_ = got;
  input->dropped_ = fresh - got;
  input->dropped_total_ += fresh - got;
  return true;
}

/// Takes back what take_...() did; a drop-newest queue's messages stay in the queue.
void Latch::Port::undo() noexcept {
  if (pins && !queue) ring.unpin(held_slot.get(), input->count_);
  if (kind != ConnectionPlan::Kind::latest) input->dropped_total_ -= input->dropped_;
  input->count_ = 0;
}

/// All ports from one commit of the writer. False, with nothing held, when the writer went on meanwhile.
inline bool Latch::Group::take() noexcept {
  Port* const first = ports.data();
  Port* const end = first + ports.size();
  const std::uint32_t n = log.newest();
  const StdAtomics::Word* record = log.record(n);
  for (Port* port = first; port != end; ++port) port->last = log.last(record, port->output);
  if (!log.holds(record, n)) return false;
  for (Port* port = first; port != end; ++port) {
    if (port->kind == ConnectionPlan::Kind::latest ? port->take_latest() : port->take_queue()) continue;
    for (Port* taken = first; taken != port; ++taken) taken->undo();
    return false;
  }
  return true;
}

void Latch::latch(Time now) noexcept {
  for (Near& port : near_) port.take();
  if (!groups_.empty()) take_groups();
  if (!expiring_.empty()) expire(now);
}

/// Empties ports whose message is too old. A pinned slot goes back at once: release() looks at what is held.
[[gnu::noinline]] void Latch::expire(Time now) noexcept {
  for (const Expiry& e : expiring_) {
    InputBase& input = *e.input;
    if (input.count_ == 0 || now - input.slots_[0]->stamp <= e.expires) continue;
    for (Group& group : groups_)
      for (Port& port : group.ports)
        if (port.input == &input && port.pins) port.ring.unpin(port.held_slot.get(), input.count_);
    input.count_ = 0;
    input.updated_ = false;
  }
}

[[gnu::noinline]] void Latch::take_groups() noexcept {
  for (Group& group : groups_)
    while (!group.take()) {
    }
}

void Latch::release() noexcept {
  for (Near& port : near_) port.input->count_ = 0;
  for (Group& group : groups_) {
    for (Port& port : group.ports) {
      InputBase& input = *port.input;
      if (port.pins || port.queue) port.ring.unpin(port.held_slot.get(), input.count_);
      if (port.queue && input.count_ != 0) port.queue->pop(input.count_);
      port.before = port.last;
      input.count_ = 0;
    }
  }
}

void Latch::merge_origins(std::int64_t (&oldest_ns)[kMaxChains]) const noexcept {
  std::fill(std::begin(oldest_ns), std::end(oldest_ns), kNoOrigin.ns);
  for (const Near& port : near_) port.input->merge_origins(port.carried_chains, oldest_ns);
  for (const Group& group : groups_)
    for (const Port& port : group.ports) port.input->merge_origins(port.carried_chains, oldest_ns);
}

}  // namespace sinew::rt
