#pragma once
// All topics of one robot in one piece of memory: a directory, then slots, rings and commit records, found by offset
// and never by pointer, so that the piece can be handed to other processes.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "hal/os.hpp"
#include "msg/describe.hpp"
#include "rt/handover.hpp"
#include "rt/port.hpp"

namespace sinew::rt {

using WriterId = std::uint32_t;      // one module's outputs, or one driver module's raw topic
using TopicId = std::uint32_t;       // index in the directory
using ConnectionId = std::uint32_t;  // one input port on one topic

inline constexpr std::uint32_t kMaxOutputs = 32;  // of one writer: commit() answers with a bit for each

struct TopicPlan {
  std::string name;  // "camera.raw"
  const msg::TypeInfo* type = nullptr;
  std::uint32_t bulk_bytes = 0;     // capacity behind the struct; types with bulk only
  std::uint32_t burst = 1;          // loans in flight
  std::uint32_t held = 0;           // slots that the writer may hold over its steps besides
  std::uint32_t history = 0;        // newest messages kept for the tap
  std::uint32_t source_chains = 0;  // bit c: chain c begins here, its origin is the message's own stamp
};

struct ConnectionPlan {
  enum class Kind : std::uint8_t { latest, drop_oldest, drop_newest };
  Kind kind = Kind::latest;
  std::uint32_t depth = 1;  // queues: messages held at most
  /// Reader and writer never run at the same time (same OS thread, real-time executor): the reader need not pin.
  bool same_thread = false;
};

/// What one topic's slots are for; `sinew check` prints it.
struct SlotSum {
  std::uint32_t burst = 0;    // loans in flight
  std::uint32_t held = 0;     // of the writer, over its steps: Raw<>::hold()
  std::uint32_t keep = 0;     // newest published: max(deepest queue, tap history, 1)
  std::uint32_t pins = 0;     // what all pinning readers may hold in their steps
  std::uint32_t pending = 0;  // depths of drop-newest queues
  std::uint32_t total() const { return burst + held + keep + pins + pending; }
};

struct SegmentOptions {
  std::uint32_t first_sequence = 1;  // of every topic; tests start shortly before the wrap
  std::uint32_t records = 16;        // commits that a slow reader may be behind while it latches; a power of two
};

/// Collects writers, topics and connections before any memory exists. Thread: owner, configure only.
class SegmentPlan {
 public:
  explicit SegmentPlan(SegmentOptions options = {}) : options_(options) {}
  WriterId add_writer(std::string name);
  /// Topics become the outputs 0, 1, ... of their writer in the order of these calls.
  TopicId add_topic(WriterId writer, TopicPlan plan);
  ConnectionId connect(TopicId topic, ConnectionPlan plan);

  std::size_t bytes() const;  // of memory that the segment needs
  SlotSum slots(TopicId topic) const;
  std::size_t topic_count() const { return topics_.size(); }
  std::size_t slot_stride(TopicId topic) const;

 private:
  friend class Segment;
  struct Topic {
    TopicPlan plan;
    WriterId writer;
    std::uint32_t output;
  };
  struct Connection {
    ConnectionPlan plan;
    TopicId topic;
  };
  struct Writer {
    std::string name;
    std::vector<TopicId> outputs;
  };
  struct Offsets;
  SegmentOptions options_;
  std::vector<Writer> writers_;
  std::vector<Topic> topics_;
  std::vector<Connection> connections_;
};

// The memory's own words. Little-endian, no padding; a later reader in another process finds everything from here.
inline constexpr std::uint64_t kSegmentMagic = 0x31474553'57454E53;  // "SNEWSEG1"
inline constexpr std::uint32_t kSegmentVersion = 2;

struct SegmentHeader {
  std::uint64_t magic, bytes;
  std::uint32_t version, topic_count, writer_count, first_sequence;
  std::uint64_t topics, writers;  // offsets of TopicEntry[], WriterEntry[]
};

struct TopicEntry {
  char name[64];
  char type[48];
  std::uint64_t schema_hash;          // of the description: rt/schema_hash.hpp
  std::uint64_t slots, states, ring;  // offsets
  std::uint64_t slot_stride;
  std::uint32_t slot_count, ring_size, message_bytes, bulk_bytes;
  std::uint32_t writer, output;
  std::uint32_t keep;  // newest messages whose slots are not written again: what an outsider can read
  std::uint32_t reserved;
};

struct WriterEntry {
  char name[64];
  std::uint64_t number, records;  // offsets of the commit number and of record_count records
  std::uint32_t outputs, record_count;
};

/// The topics in their memory. Commit writes through it, Latch reads.
/// Thread:  owner for construction; Commit and Latch of different threads may then share it.
/// Owner:   must outlive every Commit and Latch made on it.
class Segment {
 public:
  /// In memory of its own: tests and virtual time.
  explicit Segment(const SegmentPlan& plan);
  /// In zeroed memory of the caller, at least plan.bytes().
  Segment(const SegmentPlan& plan, hal::SharedMemory& memory);
  ~Segment();
  Segment(const Segment&) = delete;
  Segment& operator=(const Segment&) = delete;

  const SegmentHeader& header() const { return at<SegmentHeader>(0); }
  const TopicEntry& entry(TopicId t) const { return at<TopicEntry>(header().topics + t * sizeof(TopicEntry)); }
  const WriterEntry& writer_entry(WriterId w) const {
    return at<WriterEntry>(header().writers + w * sizeof(WriterEntry));
  }
  TopicId topic_of(WriterId w, std::uint32_t output) const { return writers_[w].topics[output]; }

 private:
  friend class Commit;
  friend class Latch;
  friend class SlotReader;
  using Queue = SlotQueue<StdAtomics>;
  struct QueueStore {
    std::unique_ptr<std::uint32_t[]> cells;
    Queue queue;
    QueueStore(std::unique_ptr<std::uint32_t[]> c, std::uint32_t cell_count, std::uint32_t depth)
        : cells(std::move(c)), queue(cells.get(), cell_count, depth) {}
  };
  struct Topic {  // what the process knows besides the memory
    TopicPlan plan;
    SlotSum sum;
    bool shared;                         // a reader may pin its slots
    const SlotHeader* newest = nullptr;  // for latest ports in the writer's own thread
    std::vector<Queue*> queues;
  };
  struct Connection {
    ConnectionPlan plan;
    TopicId topic;
    std::unique_ptr<QueueStore> queue;  // drop_newest
  };
  struct Writer {
    std::vector<TopicId> topics;
  };
  struct Free {
    void operator()(std::byte* p) const;
  };

  void build(const SegmentPlan& plan);
  template <class T>
  T& at(std::uint64_t offset) const {
    return *reinterpret_cast<T*>(base_ + offset);
  }
  TopicRing<StdAtomics> ring(TopicId t) const;
  CommitLog<StdAtomics> log(WriterId w) const;

  std::unique_ptr<std::byte[], Free> own_;
  std::byte* base_;
  std::vector<Topic> topics_;
  std::vector<Connection> connections_;
  std::vector<Writer> writers_;
};

/// A bug of ours, not of a device or a file: says what and where, and aborts.
[[noreturn]] void bug(std::string_view what, std::string_view where);

}  // namespace sinew::rt
