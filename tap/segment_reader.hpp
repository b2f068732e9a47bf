#pragma once
// An outsider's view on the topics of a running robot: read in place from read-only memory, kept apart from the writer
// by sequence numbers alone.
//
// Why a message that holds() is whole: the writer loans the slot of sequence s again only after a commit whose newest
// sequence is at least s + keep (rt/handover.hpp, TopicWriter::own), and after that commit's number it passes
// order_before_reuse(). The reader looks at the slot, passes order_reads(), and only then at the commit number. If any
// byte that it saw was of a later loan, the two fences meet on that byte, and the number that it sees is of that commit
// or a later one: the newest sequence is at least s + keep, and holds() says false. The programs of
// tests/rt/handover_programs.hpp show this for every execution of the memory model, and that it breaks without either
// fence. On x86-64 both are orders to the compiler only.
//
// The memory is not trusted: every offset and size is checked once, copied, and never read again. Values that change
// (slot index, sequence, commit number) are checked against the copy or only compared.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/os.hpp"
#include "hal/result.hpp"
#include "rt/segment.hpp"

namespace sinew::tap {

/// One topic as its robot's directory describes it.
struct Topic {
  std::string name, type;
  std::uint64_t schema_hash = 0;    // rt::schema_hash() of the writer's description
  std::uint32_t message_bytes = 0;  // of the struct
  std::uint32_t bulk_bytes = 0;     // room behind it
  std::uint32_t keep = 0;           // newest messages that can be read
  std::uint32_t bell = 0;           // its word among the doorbells
  bool known() const { return info != nullptr; }
  const msg::TypeInfo* info = nullptr;  // of this program, if it has the type with the same description
};

/// A message in place. It may change while you look at it, until holds() has said that it did not: treat all that was
/// read before as unknown bytes, and take no size from it.
struct Message {
  std::uint32_t topic = 0;
  std::uint32_t sequence = 0;
  const rt::SlotHeader* header = nullptr;
  const std::byte* data() const { return static_cast<const std::byte*>(header->message()); }
};

/// The place of a reader of every message of one topic.
struct Cursor {
  std::uint32_t next = 0;  // sequence that comes next
  bool started = false;    // false: begins with the newest message
  std::uint64_t lost = 0;  // messages that were gone before they were read
};

/// Thread:  any; a Cursor belongs to one.
/// Owner:   the memory must outlive the reader and its messages.
class SegmentReader {
 public:
  /// Checks the whole directory. Errors: bad_data (detail: number of the entry, or a size) when anything does not fit.
  static hal::Result<SegmentReader> open(std::span<const std::byte> memory);

  const std::vector<Topic>& topics() const { return topics_; }
  std::optional<std::uint32_t> find(std::string_view name) const;

  /// The newest message; nothing before the first, or when the writer is too fast for some tries.
  std::optional<Message> newest(std::uint32_t topic) const;
  /// The message after the last one; messages that are gone meanwhile are skipped and counted. Nothing: no new one yet.
  std::optional<Message> next(std::uint32_t topic, Cursor& cursor) const;
  /// True: all that was read of the message up to now is what the writer published.
  bool holds(const Message& message) const;
  /// Copies header and message with its room for bulk; false when it was overwritten meanwhile. `into` has
  /// bytes(topic). Afterwards msg::bulk_of() of a known type stays within it.
  bool copy(const Message& message, std::span<std::byte> into) const;
  std::size_t bytes(std::uint32_t topic) const {
    return sizeof(rt::SlotHeader) + topics_[topic].message_bytes + topics_[topic].bulk_bytes;
  }

 private:
  struct Place {  // checked copies of the directory
    std::size_t slots, stride, ring, number, records;
    std::uint32_t slot_count, ring_mask, record_mask, record_words, output;
  };
  explicit SegmentReader(std::span<const std::byte> memory) : memory_(memory) {}
  hal::Status read_directory();
  hal::Status read_topic(const rt::TopicEntry& entry, std::uint32_t index, std::span<const rt::WriterEntry> writers);
  std::uint32_t load(std::size_t offset, std::memory_order order) const;
  std::optional<std::uint32_t> newest_sequence(const Place& place) const;
  std::optional<Message> at(std::uint32_t topic, std::uint32_t sequence) const;

  std::span<const std::byte> memory_;
  std::uint32_t first_sequence_ = 1;
  std::vector<Topic> topics_;
  std::vector<Place> places_;
};

}  // namespace sinew::tap
