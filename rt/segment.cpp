#include "rt/segment.hpp"

#include <algorithm>
#include <bit>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>

#include "rt/schema_hash.hpp"

namespace sinew::rt {
namespace {

using Word = StdAtomics::Word;
static_assert(sizeof(Word) == 4 && Word::is_always_lock_free);
static_assert(sizeof(SlotState<StdAtomics>) == 4);
static_assert(sizeof(SegmentHeader) == 48 && sizeof(TopicEntry) == 184 && sizeof(WriterEntry) == 88);

constexpr std::size_t kLine = 64;  // slots, rings and commit numbers of different writers share no cache line
constexpr std::size_t kPage = 4096;

constexpr std::uint64_t round_up(std::uint64_t n, std::size_t to) { return (n + to - 1) / to * to; }

/// A size that no memory has stands for all that a 32-bit machine could not address.
constexpr std::size_t addressable(std::uint64_t bytes) {
  return static_cast<std::size_t>(std::min<std::uint64_t>(bytes, SIZE_MAX / kPage * kPage));
}

template <std::size_t N>
void copy_name(char (&to)[N], std::string_view from) {
  const std::size_t n = std::min(from.size(), N - 1);
  std::memcpy(to, from.data(), n);
  std::memset(to + n, 0, N - n);
}

}  // namespace

void bug(std::string_view what, std::string_view where) {
  std::fprintf(stderr, "sinew: bug: %.*s: %.*s\n", static_cast<int>(where.size()), where.data(),
               static_cast<int>(what.size()), what.data());
  std::abort();
}

WriterId SegmentPlan::add_writer(std::string name) {
  writers_.push_back({std::move(name), {}});
  return static_cast<WriterId>(writers_.size() - 1);
}

TopicId SegmentPlan::add_topic(WriterId writer, TopicPlan plan) {
  if (writer >= writers_.size() || writers_[writer].outputs.size() == kMaxOutputs) bug("too many outputs", plan.name);
  if (!plan.type || plan.type->align > kLine) bug("needs a type that is aligned to at most 64", plan.name);
  if (plan.burst == 0 || (plan.bulk_bytes != 0 && !plan.type->has_bulk())) bug("burst or bulk is wrong", plan.name);
  const auto id = static_cast<TopicId>(topics_.size());
  auto& outputs = writers_[writer].outputs;
  topics_.push_back({std::move(plan), writer, static_cast<std::uint32_t>(outputs.size())});
  outputs.push_back(id);
  return id;
}

ConnectionId SegmentPlan::connect(TopicId topic, ConnectionPlan plan) {
  if (topic >= topics_.size()) bug("connection to no topic", "segment");
  if (plan.kind == ConnectionPlan::Kind::latest) plan.depth = 1;
  if (plan.depth == 0) bug("queue of depth 0", topics_[topic].plan.name);
  connections_.push_back({plan, topic});
  return static_cast<ConnectionId>(connections_.size() - 1);
}

SlotSum SegmentPlan::slots(TopicId topic) const {
  const TopicPlan& plan = topics_[topic].plan;
  SlotSum sum{plan.burst, plan.held, std::max(plan.history, 1U), 0, 0};
  for (const Connection& c : connections_) {
    if (c.topic != topic) continue;
    if (c.plan.kind == ConnectionPlan::Kind::drop_newest) {
      sum.pending += c.plan.depth;  // the pins of its step are among them: cells are given back at release
    } else {
      sum.keep = std::max(sum.keep, c.plan.depth);
      if (!c.plan.same_thread) sum.pins += c.plan.depth;
    }
  }
  return sum;
}

std::size_t SegmentPlan::slot_stride(TopicId topic) const {
  const TopicPlan& plan = topics_[topic].plan;
  return addressable(round_up(std::uint64_t{sizeof(SlotHeader)} + plan.type->size + plan.bulk_bytes, kLine));
}

/// Where everything lies; the one place that adds up sizes.
struct SegmentPlan::Offsets {
  struct Topic {
    std::size_t states, ring, slots;
    std::uint32_t slot_count, ring_size;
  };
  struct Writer {
    std::size_t number, records;
  };
  std::size_t topics_at, writers_at, total;
  std::vector<Topic> topics;
  std::vector<Writer> writers;

  explicit Offsets(const SegmentPlan& plan) {
    std::uint64_t end = sizeof(SegmentHeader);
    const auto take = [&end](std::uint64_t bytes, std::size_t align) {
      const std::uint64_t begin = round_up(end, align);
      end = begin + bytes;
      return addressable(begin);
    };
    topics_at = take(plan.topics_.size() * sizeof(TopicEntry), kLine);
    writers_at = take(plan.writers_.size() * sizeof(WriterEntry), kLine);
    for (const auto& w : plan.writers_) {
      const std::size_t record_words = plan.options_.records * (1 + w.outputs.size());
      const std::size_t number = take((1 + record_words) * sizeof(Word), kLine);
      writers.push_back({number, number + sizeof(Word)});
    }
    for (TopicId t = 0; t < plan.topics_.size(); ++t) {
      const SlotSum sum = plan.slots(t);
      const std::uint32_t ring_size = std::bit_ceil(sum.keep + sum.burst);
      const std::size_t ring = take(ring_size * sizeof(Word), kLine);
      const std::size_t states = take(sum.total() * sizeof(Word), kLine);
      topics.push_back({states, ring, 0, sum.total(), ring_size});
    }
    for (TopicId t = 0; t < plan.topics_.size(); ++t)
      topics[t].slots =
          take(std::uint64_t{topics[t].slot_count} * plan.slot_stride(t), plan.slot_stride(t) < kPage ? kLine : kPage);
    total = addressable(round_up(end, kPage));
  }
};

std::size_t SegmentPlan::bytes() const { return Offsets(*this).total; }

void Segment::Free::operator()(std::byte* p) const { ::operator delete (p, std::align_val_t{kPage}); }

Segment::Segment(const SegmentPlan& plan) {
  const std::size_t bytes = plan.bytes();
  own_.reset(static_cast<std::byte*>(::operator new (bytes, std::align_val_t{kPage}, std::nothrow)));
  if (!own_) bug("no memory", "segment");
  std::memset(own_.get(), 0, bytes);
  base_ = own_.get();
  build(plan);
}

Segment::Segment(const SegmentPlan& plan, hal::SharedMemory& memory) : base_(memory.data()) {
  if (memory.size() < plan.bytes() || reinterpret_cast<std::uintptr_t>(base_) % kLine != 0)
    bug("memory is too small or not aligned", "segment");
  build(plan);
}

Segment::~Segment() = default;

void Segment::build(const SegmentPlan& plan) {
  const SegmentPlan::Offsets where(plan);
  const std::uint32_t first = plan.options_.first_sequence, records = plan.options_.records;
  if (!std::has_single_bit(records)) bug("number of records is not a power of two", "segment");
  new (base_) SegmentHeader{kSegmentMagic,
                            where.total,
                            kSegmentVersion,
                            static_cast<std::uint32_t>(plan.topics_.size()),
                            static_cast<std::uint32_t>(plan.writers_.size()),
                            first,
                            where.topics_at,
                            where.writers_at};

  for (WriterId w = 0; w < plan.writers_.size(); ++w) {
    const auto& writer = plan.writers_[w];
    const auto outputs = static_cast<std::uint32_t>(writer.outputs.size());
    auto* entry = new (base_ + where.writers_at + w * sizeof(WriterEntry))
        WriterEntry{{}, where.writers[w].number, where.writers[w].records, outputs, records};
    copy_name(entry->name, writer.name);
    Word* words = new (base_ + entry->number) Word[1 + std::size_t{records} * (1 + outputs)];
    words[0].store(0, std::memory_order_relaxed);
    for (std::uint32_t r = 0; r < records; ++r)
      for (std::uint32_t i = 0; i <= outputs; ++i)
        words[1 + r * (1 + outputs) + i].store(i == 0 ? 0 : first - 1, std::memory_order_relaxed);
    writers_.push_back({writer.outputs});
  }

  for (TopicId t = 0; t < plan.topics_.size(); ++t) {
    const auto& topic = plan.topics_[t];
    const auto& at_t = where.topics[t];
    const TopicPlan& p = topic.plan;
    auto* entry = new (base_ + where.topics_at + t * sizeof(TopicEntry)) TopicEntry{};
    copy_name(entry->name, p.name);
    copy_name(entry->type, p.type->name);
    entry->schema_hash = schema_hash(*p.type);
    entry->slots = at_t.slots, entry->states = at_t.states, entry->ring = at_t.ring;
    entry->slot_stride = plan.slot_stride(t);
    entry->slot_count = at_t.slot_count, entry->ring_size = at_t.ring_size;
    entry->message_bytes = p.type->size, entry->bulk_bytes = p.bulk_bytes;
    entry->writer = topic.writer, entry->output = topic.output;
    entry->keep = plan.slots(t).keep;
    new (base_ + at_t.states) SlotState<StdAtomics>[ at_t.slot_count ];
    Word* ring_words = new (base_ + at_t.ring) Word[at_t.ring_size];
    for (std::uint32_t i = 0; i < at_t.ring_size; ++i) ring_words[i].store(kNoSlot, std::memory_order_relaxed);
    for (std::uint32_t i = 0; i < at_t.slot_count; ++i) {
      auto* slot = new (base_ + at_t.slots + i * entry->slot_stride) SlotHeader;
      slot->slot = i;
      p.type->reset(slot->message());
    }
    // A held slot breaks the strict order in which the slots of an unshared topic go round.
    topics_.push_back({p, plan.slots(t), p.held != 0, nullptr, {}});
  }

  for (const auto& c : plan.connections_) {
    Connection connection{c.plan, c.topic, nullptr};
    Topic& topic = topics_[c.topic];
    if (c.plan.kind == ConnectionPlan::Kind::drop_newest) {
      const std::uint32_t cells = std::bit_ceil(c.plan.depth);
      connection.queue = std::make_unique<QueueStore>(std::make_unique<std::uint32_t[]>(cells), cells, c.plan.depth);
      topic.queues.push_back(&connection.queue->queue);
      if (topic.queues.size() > 32) bug("more than 32 drop-newest queues", topic.plan.name);
    }
    topic.shared |= !c.plan.same_thread || connection.queue;
    connections_.push_back(std::move(connection));
  }
}

TopicRing<StdAtomics> Segment::ring(TopicId t) const {
  const TopicEntry& e = entry(t);
  return {&at<SlotState<StdAtomics>>(e.states), &at<Word>(e.ring), e.ring_size - 1};
}

CommitLog<StdAtomics> Segment::log(WriterId w) const {
  const WriterEntry& e = writer_entry(w);
  return {&at<Word>(e.number), &at<Word>(e.records), e.record_count - 1, 1 + e.outputs};
}

}  // namespace sinew::rt
