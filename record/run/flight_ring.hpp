#pragma once
#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "hal/os.hpp"
#include "record/run/ring_dump.hpp"
#include "record/run/ring_memory.hpp"
#include "record/run/run_sink.hpp"

namespace sinew::record {

struct RingOptions {
  rt::Duration length{};          // at least this much of the run, where the memory holds it; 0: no ring
  std::span<std::byte> memory{};  // as RingMemory wants it
  double pixel_bytes_per_s = 0;   // at most; never more than half of the memory in `length`
  std::function<DumpFile()> next_file{};
  std::uint64_t free_floor_bytes = 0;  // of the disk that dumps go to
};

/// The result of one dump of the ring.
struct RingDumpReport {
  std::string reason, path{};
  rt::Time at{};  // of the run
  bool done = false;
  hal::Status status{};
  Dumped dumped{};
};

/// The last seconds of a run in memory: a recording that begins anew again and again, each part in the place of the
/// oldest one. After an event the ring is written to a file.
/// Thread:  owner; reports(): any.
class FlightRing {
 public:
  /// The least memory: a part holds a saved state of each module of this robot.
  static std::size_t least_bytes(const rt::Graph& graph);
  /// Errors:  bad_argument, when the memory is less than that.
  static hal::Result<std::unique_ptr<FlightRing>> open(const rt::Graph& graph, const RunDescription& description,
                                                       const RingOptions& options);
  ~FlightRing();

  /// Null before the first next_part(), and when a part could not be begun.
  RunSink* sink() { return sink_.get(); }
  /// True if it is time for another part.
  bool due(rt::Time now);
  /// True if another part has to begin before a state of so many bytes.
  bool is_full_for(std::size_t bytes);
  /// Ends the part and begins another one.
  void next_part(Beginning beginning);

  /// Writes everything up to the present part's beginning to a file, at once or, with an `os`, on a thread of its own.
  /// Call right after next_part(). Answers the number of its report; nothing while another dump is being written.
  std::optional<std::size_t> dump(const std::string& reason, rt::Time now, hal::Os* os);
  /// False while the ring still holds what was dumped before: the last dump began less than `length` ago.
  bool may_dump(rt::Time now) const { return !dumping_ && (!dumped_ || now - *dumped_ >= options_.length); }
  bool is_dumping() const { return dumping_; }
  void count_only() { not_dumped_.add(); }
  /// Waits until the last dump is written.
  void wait() { thread_.reset(); }

  std::vector<RingDumpReport> reports() const;
  std::uint64_t not_dumped() const { return not_dumped_.value(); }
  rt::Duration held(rt::Time now) const;  // of the run
  std::size_t bytes_used() const { return memory_.bytes_used(); }
  std::size_t bytes() const { return memory_.slot_bytes() * RingMemory::kSlots; }
  /// The first error of beginning a part; ok when there was none.   Thread: the owner's.
  const hal::Status& trouble() const { return trouble_; }

 private:
  FlightRing(const rt::Graph& graph, const RunDescription& description, const RingOptions& options, RingMemory memory);
  void write(std::size_t report);
  std::size_t room() const {
    return memory_.slot_bytes() - static_cast<std::size_t>(of_parts_.files.writer.free_floor_bytes);
  }

  const rt::Graph& graph_;
  const RunDescription& description_;
  const RingOptions options_;
  RingMemory memory_;
  SinkOptions of_parts_;
  std::unique_ptr<RunSink> sink_;
  std::vector<rt::Time> begins_;  // of the parts in memory, oldest first
  std::optional<rt::Time> dumped_;
  rt::Time tried_{};  // to begin a part
  hal::Status trouble_;
  std::atomic<bool> dumping_{false};
  hal::Tally not_dumped_;
  mutable std::mutex mutex_;  // of reports_, between the owner, the dumping thread and readers
  std::vector<RingDumpReport> reports_;
  std::unique_ptr<hal::Thread> thread_;
};

}  // namespace sinew::record
