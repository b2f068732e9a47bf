#include "tap/segment_reader.hpp"

#include <bit>
#include <cstring>

#include "msg/all.hpp"
#include "rt/schema_hash.hpp"

namespace sinew::tap {
namespace {

constexpr std::uint32_t kMaxEntries = 4096;
constexpr int kTries =
    16;  // tries of a reader that the writer overtakes; the reader comes back later to so fast a writer

hal::Error bad(const char* where, std::int64_t detail = 0) { return {hal::Errc::bad_data, where, detail}; }

template <std::size_t N>
std::string text_of(const char (&name)[N]) {
  return {name, ::strnlen(name, N)};
}

}  // namespace

hal::Result<SegmentReader> SegmentReader::open(std::span<const std::byte> memory) {
  SegmentReader reader(memory);
  if (auto read = reader.read_directory(); !read) return read.error();
  return reader;
}

/// True when `count` things of `size` bytes at `offset` lie within the memory, at a multiple of `align`.
static bool lies_within(std::span<const std::byte> memory, std::uint64_t offset, std::uint64_t count,
                        std::uint64_t size, std::uint64_t align) {
  if (offset % align != 0 || offset > memory.size() || size == 0) return false;
  return count <= (memory.size() - offset) / size;
}

hal::Status SegmentReader::read_directory() {
  rt::SegmentHeader header;
  if (memory_.size() < sizeof header || reinterpret_cast<std::uintptr_t>(memory_.data()) % 64 != 0)
    return bad("memory of the topics: too small", static_cast<std::int64_t>(memory_.size()));
  std::memcpy(&header, memory_.data(), sizeof header);
  if (header.magic != rt::kSegmentMagic) return bad("memory of the topics: magic");
  if (header.version != rt::kSegmentVersion) return bad("memory of the topics: version", header.version);
  if (header.bytes > memory_.size() || header.topic_count > kMaxEntries || header.writer_count > kMaxEntries)
    return bad("memory of the topics: header");
  if (!lies_within(memory_, header.topics, header.topic_count, sizeof(rt::TopicEntry), 8) ||
      !lies_within(memory_, header.writers, header.writer_count, sizeof(rt::WriterEntry), 8))
    return bad("memory of the topics: directory");
  first_sequence_ = header.first_sequence;
  std::vector<rt::WriterEntry> writers(header.writer_count);
  if (!writers.empty())
    std::memcpy(writers.data(), memory_.data() + header.writers, writers.size() * sizeof(rt::WriterEntry));
  for (std::uint32_t t = 0; t < header.topic_count; ++t) {
    rt::TopicEntry entry;
    std::memcpy(&entry, memory_.data() + header.topics + t * sizeof entry, sizeof entry);
    if (auto read = read_topic(entry, t, writers); !read) return read;
  }
  return {};
}

hal::Status SegmentReader::read_topic(const rt::TopicEntry& e, std::uint32_t index,
                                      std::span<const rt::WriterEntry> writers) {
  const auto fits = [this](std::uint64_t offset, std::uint64_t count, std::uint64_t size, std::uint64_t align) {
    return lies_within(memory_, offset, count, size, align);
  };
  if (e.writer >= writers.size()) return bad("memory of the topics: writer of topic", index);
  const rt::WriterEntry& w = writers[e.writer];
  if (w.outputs == 0 || w.outputs > rt::kMaxOutputs || e.output >= w.outputs || !std::has_single_bit(w.record_count) ||
      !fits(w.number, 1, 4, 4) || !fits(w.records, w.record_count, 4 * (1 + std::uint64_t{w.outputs}), 4))
    return bad("memory of the topics: writer of topic", index);
  const std::uint64_t used = sizeof(rt::SlotHeader) + std::uint64_t{e.message_bytes} + e.bulk_bytes;
  if (e.slot_count == 0 || e.keep == 0 || e.keep > e.slot_count || !std::has_single_bit(e.ring_size) ||
      e.slot_stride < used || !fits(e.slots, e.slot_count, e.slot_stride, alignof(rt::SlotHeader)) ||
      e.slot_stride % alignof(rt::SlotHeader) != 0 || !fits(e.ring, e.ring_size, 4, 4))
    return bad("memory of the topics: slots of topic", index);
  Topic topic{text_of(e.name), text_of(e.type), e.schema_hash, e.message_bytes, e.bulk_bytes, e.keep, e.writer};
  const msg::TypeInfo* info = msg::find_type(topic.type);
  if (info && rt::schema_hash(*info) == e.schema_hash && info->size == e.message_bytes &&
      (e.bulk_bytes == 0 || info->has_bulk()))
    topic.info = info;
  topics_.push_back(std::move(topic));
  const auto in_memory = [](std::uint64_t checked) { return static_cast<std::size_t>(checked); };
  places_.push_back({in_memory(e.slots), in_memory(e.slot_stride), in_memory(e.ring), in_memory(w.number),
                     in_memory(w.records), e.slot_count, e.ring_size - 1, w.record_count - 1, 1 + w.outputs, e.output});
  return {};
}

std::optional<std::uint32_t> SegmentReader::find(std::string_view name) const {
  for (std::uint32_t t = 0; t < topics_.size(); ++t)
    if (topics_[t].name == name) return t;
  return std::nullopt;
}

std::uint32_t SegmentReader::load(std::size_t offset, std::memory_order order) const {
  return reinterpret_cast<const rt::StdAtomics::Word*>(memory_.data() + offset)->load(order);
}

/// As rt/latch.cpp reads a commit: number, record, number in front of the record.
std::optional<std::uint32_t> SegmentReader::newest_sequence(const Place& p) const {
  using A = rt::StdAtomics;
  for (int i = 0; i < kTries; ++i) {
    const std::uint32_t n = load(p.number, A::kNumberLoad);
    const std::size_t record = p.records + std::size_t{n & p.record_mask} * p.record_words * 4;
    const std::uint32_t last = load(record + 4 * (1 + std::size_t{p.output}), A::kRecordLoad);
    if (load(record, std::memory_order_relaxed) == n) return last;
  }
  return std::nullopt;
}

std::optional<Message> SegmentReader::at(std::uint32_t topic, std::uint32_t sequence) const {
  const Place& p = places_[topic];
  const std::uint32_t slot = load(p.ring + 4 * std::size_t{sequence & p.ring_mask}, std::memory_order_relaxed);
  if (slot >= p.slot_count) return std::nullopt;  // nothing there yet, or not a slot at all
  const std::size_t place = p.slots + slot * p.stride;
  if (load(place + offsetof(rt::SlotHeader, sequence), std::memory_order_relaxed) != sequence) return std::nullopt;
  return Message{topic, sequence, reinterpret_cast<const rt::SlotHeader*>(memory_.data() + place)};
}

std::optional<Message> SegmentReader::newest(std::uint32_t topic) const {
  // The writer's core has them: asked for together, since each would be waited for before the next is known.
  const Place& place = places_[topic];
  for (const std::size_t at : {place.number, place.records, place.ring}) __builtin_prefetch(memory_.data() + at);
  for (int i = 0; i < kTries; ++i) {
    const auto last = newest_sequence(places_[topic]);
    if (!last || *last == first_sequence_ - 1) return std::nullopt;
    if (auto message = at(topic, *last)) return message;
  }
  return std::nullopt;
}

std::optional<Message> SegmentReader::next(std::uint32_t topic, Cursor& cursor) const {
  for (int i = 0; i < kTries; ++i) {
    const auto last = newest_sequence(places_[topic]);
    if (!last) return std::nullopt;
    if (!cursor.started) {
      if (*last == first_sequence_ - 1) {
        cursor.next = first_sequence_;
        cursor.started = true;
        return std::nullopt;
      }
      cursor.next = *last;
      cursor.started = true;
    }
    const auto ahead = static_cast<std::int32_t>(*last - cursor.next);
    if (ahead < 0) return std::nullopt;
    if (const std::uint32_t keep = topics_[topic].keep; static_cast<std::uint32_t>(ahead) >= keep) {
      cursor.lost += static_cast<std::uint32_t>(ahead) - (keep - 1);
      cursor.next = *last - (keep - 1);
    }
    if (auto message = at(topic, cursor.next)) {
      ++cursor.next;
      return message;
    }
  }
  return std::nullopt;
}

bool SegmentReader::holds(const Message& message) const {
  rt::StdAtomics::order_reads();
  const auto last = newest_sequence(places_[message.topic]);
  return last && *last - message.sequence < topics_[message.topic].keep;
}

bool SegmentReader::copy(const Message& message, std::span<std::byte> into) const {
  const std::size_t n = bytes(message.topic);
  if (into.size() < n) return false;
  std::memcpy(into.data(), message.header, n);
  if (!holds(message)) return false;
  const Topic& topic = topics_[message.topic];
  // The used size comes from the robot, and may be too large.
  return !topic.info || !topic.info->has_bulk() ||
         topic.info->bulk_used(into.data() + sizeof(rt::SlotHeader)) <= topic.bulk_bytes;
}

}  // namespace sinew::tap
