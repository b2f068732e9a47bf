#include "rt/latch.hpp"

#include <algorithm>
#include <bit>

namespace sinew::rt {

using Kind = ConnectionPlan::Kind;

struct Latch::Port {
  InputBase* input;
  TopicRing<StdAtomics> ring;
  const std::byte* slots;
  std::size_t stride;
  std::uint32_t output, depth;
  std::uint32_t carried_chains;
  Kind kind;
  bool pins;                // false: writer and reader never run at the same time
  bool seen = false;        // latest: held a message before
  std::uint32_t last = 0;   // sequence of the topic in the latched commit
  std::uint32_t before;     // queue: last sequence consumed; latest: sequence held by the previous step
  std::uint32_t count = 0;  // of messages held
  Segment::Queue* queue;    // drop_newest
  std::unique_ptr<const SlotHeader*[]> held;
  std::unique_ptr<std::uint32_t[]> held_slot;

  const SlotHeader* slot(std::uint32_t i) const { return reinterpret_cast<const SlotHeader*>(slots + i * stride); }
};

struct Latch::Group {
  WriterId writer;
  CommitLog<StdAtomics> log;
  std::vector<Port> ports;
};

Latch::Latch(Segment& segment) : segment_(segment) {}
Latch::~Latch() = default;

void Latch::bind(InputBase& input, ConnectionId id, Duration max_age, std::uint32_t carried_chains) {
  const Segment::Connection& c = segment_.connections_[id];
  const TopicEntry& entry = segment_.entry(c.topic);
  auto group = std::find_if(groups_.begin(), groups_.end(), [&](const Group& g) { return g.writer == entry.writer; });
  if (group == groups_.end()) group = groups_.insert(group, Group{entry.writer, segment_.log(entry.writer), {}});

  Port port{};
  port.input = &input;
  port.ring = segment_.ring(c.topic);
  port.slots = &segment_.at<std::byte>(entry.slots);
  port.stride = entry.slot_stride;
  port.output = entry.output;
  port.depth = c.plan.depth;
  port.carried_chains = carried_chains & ((1U << kMaxChains) - 1);
  port.kind = c.plan.kind;
  port.pins = !c.plan.same_thread;
  port.before = segment_.header().first_sequence - 1;
  port.queue = c.queue ? &c.queue->queue : nullptr;
  port.held = std::make_unique<const SlotHeader*[]>(port.depth);
  port.held_slot = std::make_unique<std::uint32_t[]>(port.depth);
  input.slots_ = port.held.get();
  input.max_age_ = max_age;
  group->ports.push_back(std::move(port));
}

/// The `count` newest messages up to port.last. False, and nothing is held, when one of them is gone.
bool Latch::take_newest(Port& port, std::uint32_t count) noexcept {
  if (port.pins) {
    const auto sequence_in = [&port](std::uint32_t s) { return port.slot(s)->sequence; };
    return port.ring.pin(port.last, count, sequence_in, port.held_slot.get(), port.count);
  }
  for (port.count = 0; port.count < count; ++port.count) {
    const std::uint32_t slot = port.ring.slot_of(port.last - (count - 1 - port.count));
    if (slot == kNoSlot) break;
    port.held_slot[port.count] = slot;
  }
  return true;
}

bool Latch::take(Port& port) noexcept {
  const std::uint32_t fresh = port.last - port.before;
  switch (port.kind) {
    case Kind::latest:
      if (!take_newest(port, 1)) return false;
      port.input->updated_ = port.count != 0 && (!port.seen || fresh != 0);
      break;
    case Kind::drop_oldest:
      if (!take_newest(port, std::min(fresh, port.depth))) return false;
      port.input->dropped_ = fresh - port.count;
      break;
    case Kind::drop_newest:  // pinned by the writer
      port.count = port.queue->take(
          port.last, [&port](std::uint32_t s) { return port.slot(s)->sequence; }, port.held_slot.get());
      port.input->dropped_ = fresh - port.count;
      break;
  }
  for (std::uint32_t i = 0; i < port.count; ++i) port.held[i] = port.slot(port.held_slot[i]);
  return true;
}

/// Takes back take(): a queue's messages stay in the queue.
void Latch::undo(Port& port) noexcept {
  if (port.pins && port.kind != Kind::drop_newest) port.ring.unpin(port.held_slot.get(), port.count);
  port.count = 0;
}

bool Latch::take_group(Group& group) noexcept {
  const std::uint32_t n = group.log.newest();
  for (Port& port : group.ports) port.last = group.log.last(n, port.output);
  if (!group.log.holds(n)) return false;
  for (std::size_t i = 0; i < group.ports.size(); ++i) {
    if (take(group.ports[i])) continue;
    while (i-- > 0) undo(group.ports[i]);
    return false;
  }
  return true;
}

void Latch::latch() noexcept {
  for (Group& group : groups_) {
    while (!take_group(group)) {
    }
    for (Port& port : group.ports) {
      port.input->count_ = port.count;
      if (port.kind != Kind::latest) port.input->dropped_total_ += port.input->dropped_;
    }
  }
}

void Latch::release() noexcept {
  for (Group& group : groups_) {
    for (Port& port : group.ports) {
      if (port.pins || port.queue) port.ring.unpin(port.held_slot.get(), port.count);
      if (port.queue && port.count != 0) port.queue->pop(port.count);
      port.before = port.last;
      port.seen |= port.count != 0;
      port.count = port.input->count_ = 0;
    }
  }
}

void Latch::merge_origins(std::int64_t (&oldest_ns)[kMaxChains]) const noexcept {
  std::fill(std::begin(oldest_ns), std::end(oldest_ns), kNoOrigin.ns);
  for (const Group& group : groups_)
    for (const Port& port : group.ports)
      for (std::uint32_t chains = port.count ? port.carried_chains : 0; chains; chains &= chains - 1) {
        const int c = std::countr_zero(chains);
        for (std::uint32_t i = 0; i < port.count; ++i)
          oldest_ns[c] = std::min(oldest_ns[c], port.held[i]->origin_ns[c]);
      }
}

}  // namespace sinew::rt
