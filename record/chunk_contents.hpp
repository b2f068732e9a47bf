#pragma once
#include <optional>
#include <vector>

#include "hal/file.hpp"
#include "record/compression.hpp"
#include "record/problem.hpp"
#include "record/summary.hpp"

namespace sinew::record {

/// The most that a reader spends on a file's claims.
struct ReadLimits {
  std::uint64_t record_bytes = 1ull << 30;  // one record or one chunk, compressed or not
  std::uint64_t open_bytes = 2ull << 30;    // all chunks that overlap in log time
};

/// Where messages are: a chunk, or a run of records outside of chunks.
struct Block {
  std::uint64_t offset = 0, length = 0;  // whole records
  std::uint64_t start_time = 0, end_time = 0;
  std::vector<std::uint16_t> channels;  // those with messages in it; empty: not known
  bool loose = false;                   // no chunk
  bool judged = false;                  // its messages must have these times
};

/// One block in memory, checked and taken apart.
/// Owner:   views into it stay valid until the next load.
class ChunkContents {
 public:
  struct Entry {
    std::uint64_t log_time = 0;
    std::uint64_t place = 0, size = 0;  // of the whole message record, in records()
    std::uint16_t channel = 0;
  };
  /// False: no part of it can be used.
  bool load(hal::InputFile& file, const Block& block, const ReadLimits& limits, Decompressor& decompressor,
            FileProblem& problem);
  /// The chunk's own head; nothing for a loose block.
  const std::optional<ChunkHead>& head() const { return head_; }
  const std::vector<Entry>& entries() const { return entries_; }  // in the order of the file
  const std::vector<Schema>& schemas() const { return schemas_; }
  const std::vector<Channel>& channels() const { return channels_; }
  std::span<const std::byte> records() const { return records_; }
  std::uint64_t start_time() const { return start_time_; }
  std::uint64_t end_time() const { return end_time_; }
  void message(const Entry& entry, Stamps& stamps, std::span<const std::byte>& data) const;

 private:
  bool unpack(const Block& block, const ReadLimits& limits, Decompressor& decompressor, FileProblem& problem);
  bool take_apart(const Block& block, FileProblem& problem);
  Buffer stored_, unpacked_;
  std::optional<ChunkHead> head_;
  std::span<const std::byte> records_;
  std::vector<Entry> entries_;
  std::vector<Schema> schemas_;
  std::vector<Channel> channels_;
  std::uint64_t start_time_ = 0, end_time_ = 0;
};

/// Adds definitions to those already known.
/// Errors:  false when a definition contradicts a known one or names an unknown schema.
bool merge_definitions(const std::vector<Schema>& schemas, const std::vector<Channel>& channels, std::uint64_t offset,
                       Summary& known, FileProblem& problem);

/// Reads whole records. Errors: false; io, truncated, too_large.
bool read_bytes(hal::InputFile& file, std::uint64_t offset, std::uint64_t length, const ReadLimits& limits, Buffer& to,
                FileProblem& problem);

/// Takes the record at the beginning off `rest`. False: the record reaches beyond the end.
bool take_record(std::span<const std::byte>& rest, Op& op, std::span<const std::byte>& content);

}  // namespace sinew::record
