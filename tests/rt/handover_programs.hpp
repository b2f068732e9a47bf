#pragma once
// Small programs around rt/handover.hpp, for the memory model. Each checks the promises of the hand-over: nothing torn,
// no race, outputs of one commit together, no slot lost, shared or missing.
#include <array>

#include "memory_model.hpp"
#include "rt/handover.hpp"

namespace sinew::rt {

using Order = std::memory_order;

/// The model's atomics; the orders are variables, so that a test can weaken one of them.
struct ModelAtomics {
  using Word = model::Word;
  template <class T>
  using Plain = model::Plain<T>;
  static inline Order kOwn, kPublish, kPin, kUnpin, kRecordStore, kRecordLoad, kNumberStore, kNumberLoad, kHeadStore,
      kHeadLoad, kTailStore, kTailLoad;

  struct Named {
    const char* name;
    Order* order;
    Order production;
  };
  static const std::array<Named, 12>& all() {
    using S = StdAtomics;
    static const std::array<Named, 12> orders{{{"kOwn", &kOwn, S::kOwn},
                                               {"kPublish", &kPublish, S::kPublish},
                                               {"kPin", &kPin, S::kPin},
                                               {"kUnpin", &kUnpin, S::kUnpin},
                                               {"kRecordStore", &kRecordStore, S::kRecordStore},
                                               {"kRecordLoad", &kRecordLoad, S::kRecordLoad},
                                               {"kNumberStore", &kNumberStore, S::kNumberStore},
                                               {"kNumberLoad", &kNumberLoad, S::kNumberLoad},
                                               {"kHeadStore", &kHeadStore, S::kHeadStore},
                                               {"kHeadLoad", &kHeadLoad, S::kHeadLoad},
                                               {"kTailStore", &kTailStore, S::kTailStore},
                                               {"kTailLoad", &kTailLoad, S::kTailLoad}}};
    return orders;
  }
  static inline bool fence_before_reuse = true, fence_after_reads = true;
  static void order_before_reuse() {
    if (fence_before_reuse) model::release_fence();
  }
  static void order_reads() {
    if (fence_after_reads) model::acquire_fence();
  }
  static void as_in_production() {
    for (const Named& n : all()) *n.order = n.production;
    fence_before_reuse = fence_after_reads = true;
  }
};

inline constexpr std::uint32_t kFirst = 0xFFFFFFFF;  // sequences wrap at the second message

/// One topic: `slots` slots with a header's sequence and a payload of two words.
template <std::uint32_t slots, std::uint32_t ring_size>
struct ModelTopic {
  std::array<SlotState<ModelAtomics>, slots> states;
  std::array<model::Word, ring_size> ring;
  std::array<model::Plain<std::uint32_t>, slots> sequence, payload;
  std::array<std::uint32_t, slots> published{};
  TopicWriter<ModelAtomics> writer;

  ModelTopic() {
    for (auto& r : ring) r.store(kNoSlot, std::memory_order_relaxed);
    writer.ring = {states.data(), ring.data(), ring_size - 1};
    writer.slot_count = slots;
    writer.published = published.data();
    writer.start(kFirst);
  }
  /// Loans, fills and publishes one message; its content is its sequence. False when no slot was free.
  bool write() {
    const std::uint32_t slot = writer.own();
    if (slot == kNoSlot) return false;
    payload[slot] = writer.next_sequence;
    sequence[slot] = writer.next_sequence;
    writer.publish(slot);
    return true;
  }
  auto sequence_in() const {
    return [this](std::uint32_t slot) -> std::uint32_t { return sequence[slot]; };
  }
  void check(std::uint32_t slot, std::uint32_t expected) const {
    model::require(payload[slot] == expected, "the payload is not the message's");
  }
};

template <std::uint32_t outputs, std::uint32_t records>
struct ModelLog {
  model::Word number{0};
  std::array<model::Word, records*(1 + outputs)> words;
  CommitLog<ModelAtomics> log{&number, words.data(), records - 1, 1 + outputs};
  ModelLog() {
    for (std::uint32_t r = 0; r < records; ++r)
      for (std::uint32_t o = 0; o < outputs; ++o) words[r * (1 + outputs) + 1 + o].store(kFirst - 1, Order::relaxed);
  }
  void commit(std::uint32_t n, std::array<std::uint32_t, outputs> last) {
    model::Word* at = log.open(n);
    for (std::uint32_t o = 0; o < outputs; ++o) log.set_last(at, o, last[o]);
    log.publish(n);
  }
};

/// A writer publishes two outputs in each commit; readers latch both. Records come round at once (one record).
template <int readers, std::uint32_t commits, std::uint32_t records, std::uint32_t attempts>
struct PairProgram {
  static constexpr int threads = 1 + readers;
  static constexpr std::uint32_t kSlots = 2 + readers;  // burst, keep, one pin each
  ModelTopic<kSlots, 2> a, b;
  ModelLog<2, records> log;

  void run(int thread) { thread == 0 ? write() : read(); }
  void write() {
    for (std::uint32_t n = 1; n <= commits; ++n) {
      model::require(a.write() && b.write(), "out of slots");
      log.commit(n, {a.writer.next_sequence - 1, b.writer.next_sequence - 1});
    }
  }
  void read() {
    std::uint32_t newest = 0;
    for (std::uint32_t i = 0; i < attempts; ++i) {
      const std::uint32_t n = log.log.newest();
      model::require(n >= newest, "commits go backwards");
      newest = n;
      const model::Word* at = log.log.record(n);
      const std::uint32_t last_a = log.log.last(at, 0), last_b = log.log.last(at, 1);
      if (!log.log.holds(at, n)) continue;
      model::require(last_a == kFirst - 1 + n && last_b == last_a, "the outputs are not of one commit");
      std::uint32_t slot_a = 0, slot_b = 0, held_a = 0, held_b = 0;
      if (!a.writer.ring.pin(last_a, 1, a.sequence_in(), &slot_a, held_a)) continue;
      if (!b.writer.ring.pin(last_b, 1, b.sequence_in(), &slot_b, held_b)) {
        a.writer.ring.unpin(&slot_a, held_a);
        continue;
      }
      model::require(held_a == (n == 0 ? 0 : 1) && held_a == held_b, "a message is missing");
      if (n == 0) continue;
      a.check(slot_a, last_a);
      b.check(slot_b, last_b);
      a.writer.ring.unpin(&slot_a, 1);
      b.writer.ring.unpin(&slot_b, 1);
    }
  }
  void finish() {
    for (std::uint32_t s = 0; s < kSlots; ++s)
      model::require(a.states[s].idle() && b.states[s].idle(), "a slot stays pinned or owned");
  }
};

/// One output; slots come round as fast as the plan allows, or faster when `slots` is below it (then the writer may
/// find none and gives up). Readers take the newest `depth` messages.
template <int readers, std::uint32_t commits, std::uint32_t depth, std::uint32_t slots, std::uint32_t attempts>
struct LapProgram {
  static constexpr int threads = 1 + readers;
  static constexpr bool planned = slots >= 1 + depth + readers * depth;  // burst, keep, pins
  ModelTopic<slots, depth + 1 <= 2 ? 2 : 4> topic;
  ModelLog<1, 2> log;

  LapProgram() { topic.writer.keep = depth, topic.writer.start(kFirst); }
  void run(int thread) { thread == 0 ? write() : read(); }
  void write() {
    for (std::uint32_t n = 1; n <= commits; ++n) {
      const bool written = topic.write();
      model::require(written || !planned, "out of slots");
      if (!written) return;
      log.commit(n, {topic.writer.next_sequence - 1});
    }
  }
  void read() {
    std::uint32_t before = kFirst - 1;
    for (std::uint32_t i = 0; i < attempts; ++i) {
      const std::uint32_t n = log.log.newest();
      const model::Word* at = log.log.record(n);
      const std::uint32_t last = log.log.last(at, 0);
      if (!log.log.holds(at, n)) continue;
      const std::uint32_t fresh = last - before, count = fresh < depth ? fresh : depth;
      std::array<std::uint32_t, depth> slot{};
      std::uint32_t held = 0;
      if (!topic.writer.ring.pin(last, count, topic.sequence_in(), slot.data(), held)) continue;
      model::require(held == count, "a message is missing");
      for (std::uint32_t k = 0; k < held; ++k) topic.check(slot[k], last - (held - 1 - k));
      topic.writer.ring.unpin(slot.data(), held);
      before = last;
    }
  }
  void finish() {
    for (auto& s : topic.states) model::require(s.idle(), "a slot stays pinned or owned");
  }
};

/// A drop-newest queue: the messages that the reader gets and the dropped ones add up, in order, none twice.
template <std::uint32_t commits, std::uint32_t depth, std::uint32_t latches>
struct QueueProgram {
  static constexpr int threads = 2;
  static constexpr std::uint32_t kSlots = 2 + depth, kCells = depth == 1 ? 1 : 2;  // burst, keep, pending
  static_assert(depth <= 2);
  ModelTopic<kSlots, 2> topic;
  ModelLog<1, 2> log;
  std::array<model::Plain<std::uint32_t>, kCells> cells;
  SlotQueue<ModelAtomics> queue{cells.data(), kCells, depth};
  SlotQueue<ModelAtomics>* queues[1] = {&queue};

  QueueProgram() { topic.writer.queues = queues, topic.writer.queue_count = 1; }
  void run(int thread) { thread == 0 ? write() : read(); }
  void write() {
    for (std::uint32_t n = 1; n <= commits; ++n) {
      model::require(topic.write(), "out of slots");
      log.commit(n, {topic.writer.next_sequence - 1});
    }
  }
  void read() {
    std::uint32_t before = kFirst - 1;
    for (std::uint32_t i = 0; i < latches; ++i) {
      const std::uint32_t n = log.log.newest();
      const model::Word* at = log.log.record(n);
      const std::uint32_t last = log.log.last(at, 0);
      if (!log.log.holds(at, n)) continue;
      std::array<std::uint32_t, depth> slot{};
      const std::uint32_t held = queue.take(last, topic.sequence_in(), slot.data());
      model::require(held <= last - before, "more messages than were published");
      model::require(last == before || before != kFirst - 1 || held > 0, "the first message has room and is lost");
      std::uint32_t previous = before;
      for (std::uint32_t k = 0; k < held; ++k) {
        const std::uint32_t sequence = topic.sequence[slot[k]];
        model::require(static_cast<std::int32_t>(sequence - previous) > 0, "a message came twice or out of order");
        topic.check(slot[k], sequence);
        previous = sequence;
      }
      topic.writer.ring.unpin(slot.data(), held);
      if (held) queue.pop(held);
      before = last;
    }
  }
  void finish() {
    std::uint32_t pinned = 0;
    for (auto& s : topic.states) pinned += !s.idle();
    model::require(pinned == queue.pending(), "slots pinned and slots queued differ");
  }
};

/// A writer and readers in other processes, which pin nothing and check again afterwards (tap/segment_reader.hpp). The
/// payload's words are relaxed atomics here, because the reader must notice torn reads; they may happen. Words may be
/// of any message; the words of a message that still holds() must be that message's.
template <int readers, std::uint32_t commits, std::uint32_t keep, std::uint32_t slots, std::uint32_t attempts>
struct OutsiderProgram {
  static constexpr int threads = 1 + readers;
  static constexpr std::uint32_t kRing = keep + 1 <= 2 ? 2 : 4;
  static_assert(slots >= keep + 1);  // burst 1
  std::array<SlotState<ModelAtomics>, slots> states;
  std::array<model::Word, kRing> ring;
  std::array<model::Word, slots> sequence, payload;
  std::array<std::uint32_t, slots> published{};
  TopicWriter<ModelAtomics> writer;
  ModelLog<1, 2> log;

  OutsiderProgram() {
    for (auto& r : ring) r.store(kNoSlot, Order::relaxed);
    writer.ring = {states.data(), ring.data(), kRing - 1};
    writer.slot_count = slots, writer.keep = keep, writer.shared = false, writer.published = published.data();
    writer.start(kFirst);
  }
  void run(int thread) { thread == 0 ? write() : read(); }
  void write() {
    for (std::uint32_t n = 1; n <= commits; ++n) {
      const std::uint32_t slot = writer.own();
      payload[slot].store(writer.next_sequence, Order::relaxed);
      sequence[slot].store(writer.next_sequence, Order::relaxed);
      writer.publish(slot);
      log.commit(n, {writer.next_sequence - 1});
    }
  }
  bool newest(std::uint32_t& last) const {
    const std::uint32_t n = log.log.newest();
    const model::Word* at = log.log.record(n);
    last = log.log.last(at, 0);
    return log.log.holds(at, n);
  }
  void read() {
    for (std::uint32_t i = 0; i < attempts; ++i) {
      std::uint32_t last = 0, again = 0;
      if (!newest(last) || last == kFirst - 1) continue;
      const std::uint32_t oldest = last - (keep - 1);
      const std::uint32_t wanted = static_cast<std::int32_t>(oldest - kFirst) < 0 ? last : oldest;
      const std::uint32_t slot = writer.ring.slot_of(wanted);
      if (slot == kNoSlot || sequence[slot].load(Order::relaxed) != wanted) continue;
      const std::uint32_t content = payload[slot].load(Order::relaxed);
      ModelAtomics::order_reads();
      if (!newest(again) || again - wanted >= keep) continue;
      model::require(content == wanted, "an outsider took an overwritten message for whole");
    }
  }
  void finish() {}
};

}  // namespace sinew::rt
