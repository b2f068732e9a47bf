#pragma once
// How a message changes hands between one writer and its readers: slot states, the log of commits, and the queues that
// drop the newest. Templated on the atomics, so that tests/rt/handover_test.cpp runs these very functions under a model
// of the C++ memory order, where every order named in StdAtomics fails a test when it is weakened. No waiting, 32-bit
// words only, and no fence but the one that readers in other processes need.
//
// The life of a slot: the writer owns it (CAS 0 -> writer bit), fills it, publishes it (the bit goes, the pins of
// drop-newest queues come), names it in the topic's ring, and writes the commit that makes all outputs of a step
// visible at once. A reader takes the number of the newest commit, the last sequence of each output in that commit, the
// slot in the ring, pins it and looks whether the slot still holds that sequence; if not, the writer went round
// meanwhile, and the reader starts again from the newest commit.
//
// A writer may own several slots at once, loans of one step or held over many (Raw<>::hold()). To readers a held slot
// is one whose loan takes long. Between own() and publish() only the owner looks at a slot's state, so the order in
// which owned slots are published does not matter to the tests above.
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace sinew::rt {

/// The atomics of production, with every memory order of the hand-over by name, its partner and its reason.
struct StdAtomics {
  using Word = std::atomic<std::uint32_t>;
  template <class T>
  using Plain = T;

  // Writer owns a slot <- kUnpin: readers have finished reading before it is written again.
  static constexpr std::memory_order kOwn = std::memory_order_acquire;
  // Writer publishes a slot -> kPin: a reader that pins it sees header and payload as published.
  static constexpr std::memory_order kPublish = std::memory_order_release;
  static constexpr std::memory_order kPin = std::memory_order_acquire;
  static constexpr std::memory_order kUnpin = std::memory_order_release;
  // Words of a commit record: a reader that meets a newer word also sees the newer number in front of it.
  static constexpr std::memory_order kRecordStore = std::memory_order_release;
  static constexpr std::memory_order kRecordLoad = std::memory_order_acquire;
  // Number of the newest commit: a reader that sees it sees the record, rings and queues of that commit.
  static constexpr std::memory_order kNumberStore = std::memory_order_release;
  static constexpr std::memory_order kNumberLoad = std::memory_order_acquire;
  // Queue, writer to reader: cells up to the head are written, and the slots that they name are published.
  static constexpr std::memory_order kHeadStore = std::memory_order_release;
  static constexpr std::memory_order kHeadLoad = std::memory_order_acquire;
  // Queue, reader to writer: cells before the tail have been read and may be written again.
  static constexpr std::memory_order kTailStore = std::memory_order_release;
  static constexpr std::memory_order kTailLoad = std::memory_order_acquire;

  // Readers in other processes cannot pin; they look at the commit number again after they have read. The writer comes
  // here between a commit and its later writes into slots; the outsider between reading a slot and that second look. An
  // outsider that saw any byte of a later loan sees the commit that allowed it. These two are the only fences; stores
  // of x86-64 stay in order, as loads do, so there they are orders to the compiler.
  static void order_before_reuse() {
#ifdef __x86_64__
    std::atomic_signal_fence(std::memory_order_release);
#else
    std::atomic_thread_fence(std::memory_order_release);
#endif
  }
  static void order_reads() {
#ifdef __x86_64__
    std::atomic_signal_fence(std::memory_order_acquire);
#else
    std::atomic_thread_fence(std::memory_order_acquire);
#endif
  }
};

inline constexpr std::uint32_t kNoSlot = 0xFFFFFFFF;  // in a ring: nothing was ever published here

/// Who may touch a slot: 0 nobody, n pinned by n readers or queues, high bit: the writer.
template <class A>
class SlotState {
 public:
  static constexpr std::uint32_t kWriter = 0x80000000;

  /// Writer: takes the slot if it is not held.
  bool try_own() {
    std::uint32_t free = 0;
    return word_.compare_exchange_strong(free, kWriter, A::kOwn, std::memory_order_relaxed);
  }
  /// Writer: gives the slot to the readers, already pinned `pins` times on behalf of queues. Readers may be backing off
  /// at this moment, so this adds and never stores.
  void publish(std::uint32_t pins) { word_.fetch_add(pins - kWriter, A::kPublish); }
  /// Reader: false when the writer has the slot; nothing was read then, so backing off needs no order.
  bool pin() {
    if ((word_.fetch_add(1, A::kPin) & kWriter) == 0) return true;
    word_.fetch_sub(1, std::memory_order_relaxed);
    return false;
  }
  void unpin() { word_.fetch_sub(1, A::kUnpin); }
  /// True when it is not held; for tests, when all threads are done.
  bool idle() const { return word_.load(std::memory_order_relaxed) == 0; }

 private:
  typename A::Word word_{0};
};

/// The slots of one topic as its readers find them: ring[sequence & mask] is the slot of that sequence. In what follows
/// `sequence_in(slot)` reads the header of a slot that is pinned or cannot change.
template <class A>
struct TopicRing {
  SlotState<A>* states = nullptr;
  typename A::Word* ring = nullptr;
  std::uint32_t mask = 0;

  /// A hint only: what it names is checked under the pin, so it needs no order of its own.
  std::uint32_t slot_of(std::uint32_t sequence) const { return ring[sequence & mask].load(std::memory_order_relaxed); }
  void name(std::uint32_t sequence, std::uint32_t slot) {
    ring[sequence & mask].store(slot, std::memory_order_relaxed);
  }

  /// Reader: pins the slots of the `count` sequences up to `last`, oldest first. False, with nothing pinned, when one
  /// is gone: the writer went on, look again. `held` counts the slots taken: all, or none when nothing was ever
  /// published.
  template <class SequenceIn>
  bool pin(std::uint32_t last, std::uint32_t count, SequenceIn&& sequence_in, std::uint32_t* slots,
           std::uint32_t& held) const {
    for (held = 0; held < count; ++held) {
      const std::uint32_t sequence = last - (count - 1 - held), slot = slot_of(sequence);
      if (slot == kNoSlot) return true;
      if (pin_one(slot, sequence, sequence_in)) {
        slots[held] = slot;
        continue;
      }
      unpin(slots, held);
      held = 0;
      return false;
    }
    return true;
  }
  void unpin(const std::uint32_t* slots, std::uint32_t count) const {
    for (std::uint32_t i = 0; i < count; ++i) states[slots[i]].unpin();
  }

 private:
  template <class SequenceIn>
  bool pin_one(std::uint32_t slot, std::uint32_t sequence, SequenceIn&& sequence_in) const {
    if (!states[slot].pin()) return false;
    if (sequence_in(slot) == sequence) return true;
    states[slot].unpin();
    return false;
  }
};

/// The commits of one writer: the number of the newest, and a ring of records {number, last sequence of each output}.
/// A record is read without a lock: the writer stores the new number before the new words, the reader looks at the
/// number after the words.
template <class A>
struct CommitLog {
  typename A::Word* number = nullptr;
  typename A::Word* records = nullptr;
  std::uint32_t mask = 0;          // records - 1
  std::uint32_t record_words = 0;  // 1 + outputs

  using Word = typename A::Word;
  Word* record(std::uint32_t n) const { return records + std::size_t{n & mask} * record_words; }

  /// Writer, in this order: the record of commit n, the last sequence of every output, then the number.
  Word* open(std::uint32_t n) const {
    Word* at = record(n);
    at->store(n, std::memory_order_relaxed);
    return at;
  }
  static void set_last(Word* at, std::uint32_t output, std::uint32_t sequence) {
    at[1 + output].store(sequence, A::kRecordStore);
  }
  void publish(std::uint32_t n) const {
    number->store(n, A::kNumberStore);
    A::order_before_reuse();
  }

  /// Reader, in this order: n, the sequences in record(n), then whether the record still is that of commit n.
  std::uint32_t newest() const { return number->load(A::kNumberLoad); }
  static std::uint32_t last(const Word* at, std::uint32_t output) { return at[1 + output].load(A::kRecordLoad); }
  static bool holds(const Word* at, std::uint32_t n) { return at->load(std::memory_order_relaxed) == n; }
};

/// Slot indices on their way to one drop-newest connection. One writer, one reader. Each slot in it is pinned once.
template <class A>
class SlotQueue {
 public:
  using Cell = typename A::template Plain<std::uint32_t>;
  /// `cells`: a power of two, at least `depth`.
  SlotQueue(Cell* cells, std::uint32_t cell_count, std::uint32_t depth)
      : cells_(cells), mask_(cell_count - 1), depth_(depth) {}

  bool has_room() const { return written_ - tail_.load(A::kTailLoad) < depth_; }
  void push(std::uint32_t slot) {
    cells_[written_ & mask_] = slot;
    head_.store(++written_, A::kHeadStore);
  }

  /// Takes the slots with sequences up to `last`, oldest first, into `slots`; answers how many. They stay in the queue,
  /// pinned, until pop(). What later commits pushed waits for the next step.
  template <class SequenceIn>
  std::uint32_t take(std::uint32_t last, SequenceIn&& sequence_in, std::uint32_t* slots) const {
    const std::uint32_t size = head_.load(A::kHeadLoad) - read_;
    for (std::uint32_t i = 0; i < size; ++i) {
      const std::uint32_t slot = cells_[(read_ + i) & mask_];
      if (static_cast<std::int32_t>(sequence_in(slot) - last) > 0) return i;
      slots[i] = slot;
    }
    return size;
  }
  /// The first n have been read and unpinned.
  void pop(std::uint32_t n) { tail_.store(read_ += n, A::kTailStore); }
  /// Messages in it; for tests, when all threads are done.
  std::uint32_t pending() const { return written_ - read_; }

 private:
  Cell* cells_;
  std::uint32_t mask_, depth_;
  typename A::Word head_{0};
  std::uint32_t written_ = 0;  // writer's own copy of head_
  alignas(64) typename A::Word tail_{0};
  std::uint32_t read_ = 0;  // reader's own copy of tail_
};

/// The writer's side of one topic: which slot to loan next, and how a filled slot reaches ring, queues and pins.
/// Owner:   `published` has a word for each slot; it and `queues` are the caller's and outlive this.
template <class A>
struct TopicWriter {
  TopicRing<A> ring;
  std::uint32_t slot_count = 0;
  std::uint32_t keep = 1;  // newest published slots that are not loaned again
  bool shared = true;      // false: no reader pins, so slots go round in strict order, states untouched
  std::uint32_t next_sequence = 1;
  std::uint32_t cursor = 0;            // slot to try first
  std::uint32_t* published = nullptr;  // per slot: its newest sequence
  SlotQueue<A>* const* queues = nullptr;
  std::uint32_t queue_count = 0;  // at most 32

  void start(std::uint32_t first_sequence) {
    next_sequence = first_sequence;
    for (std::uint32_t s = 0; s < slot_count; ++s) published[s] = first_sequence - 1 - keep;
  }

  /// A slot that is neither among the newest `keep` nor held by anybody; kNoSlot when there is none. With the planned
  /// number of slots one is free at every instant. A round fails only if a reader moved meanwhile, and a reader moves
  /// to a slot other than the newest at most twice without a commit: twice as many rounds as slots always suffice.
  std::uint32_t own() { return shared ? own_shared() : own_in_turn(); }
  std::uint32_t own_in_turn() {
    const std::uint32_t slot = cursor;
    cursor = slot + 1 == slot_count ? 0 : slot + 1;
    return slot;
  }

  /// Publishes an owned slot whose header holds next_sequence. It becomes visible with the commit.
  void publish(std::uint32_t slot) {
    if (shared) give(slot);
    publish_in_turn(slot);
  }
  void publish_in_turn(std::uint32_t slot) { ring.name(next_sequence++, slot); }

 private:
  std::uint32_t own_shared() {
    for (std::uint32_t look = 0; look < 2 * slot_count * slot_count; ++look) {
      const std::uint32_t slot = cursor;
      cursor = slot + 1 == slot_count ? 0 : slot + 1;
      if (next_sequence - published[slot] > keep && ring.states[slot].try_own()) return slot;
    }
    return kNoSlot;
  }

  void give(std::uint32_t slot) {
    published[slot] = next_sequence;
    std::uint32_t pins = 0, takers = 0;  // decided once: a reader may make room at any moment
    for (std::uint32_t i = 0; i < queue_count; ++i) {
      if (!queues[i]->has_room()) continue;
      ++pins;
      takers |= 1U << i;
    }
    ring.states[slot].publish(pins);
    for (std::uint32_t i = 0; takers != 0; ++i, takers >>= 1)
      if (takers & 1) queues[i]->push(slot);
  }
};

}  // namespace sinew::rt
