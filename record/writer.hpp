#pragma once
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "hal/file.hpp"
#include "record/format.hpp"

namespace sinew::record {

struct WriterOptions {
  std::string profile{};  // "ros2" for files in which every message is a ROS 2 type
  std::string library = "sinew";
  Compression compression = Compression::lz4;
  int zstd_level = 1;
  std::size_t chunk_bytes = 1 << 20;  // of messages, before compression; a longer message gets its own chunk
  std::chrono::nanoseconds chunk_duration = std::chrono::seconds(1);  // of log time
  std::uint64_t free_floor_bytes = 0;  // what write(), tick(), flush() and attach() leave of the disk
};

/// How the messages of a channel are kept.
enum class Packing : std::uint8_t {
  packed,  // as the options say
  plain,   // never compressed: images, which gain nothing; a large one is written without a copy
};

/// What happened so far. Messages count when their chunk is in the file.
struct WriterCounters {
  std::uint64_t messages = 0, chunks = 0, file_bytes = 0;
  std::uint64_t failed_writes = 0;  // disk full or broken; the part that was written was removed again
  std::uint64_t failed_syncs = 0;   // written, but a loss of power may take it
};

/// Writes an MCAP file: chunks with checksums and indexes, attachments, metadata, a full summary. However the process
/// ends, everything up to the last whole chunk is in the file; a loss of power takes at most chunk_duration.
///
/// write() copies the message and returns. When the chunk in memory is full or old, write() first compresses and writes
/// that chunk; only then can it wait for the disk. Memory is taken per channel and, while chunks grow to their usual
/// size, per chunk; never per message.
///
/// Thread:  owner, an ordinary one.
/// Errors:  io when the file reports it, with errno in detail (28, ENOSPC: full, or down to the free floor). The
///          message is not taken then, and the file ends with its last whole chunk. The chunk in memory is kept;
///          write() and tick() try it again kRetryAfter of log time later and answer with the same error until then.
///          closed after finish(), or when the file could not be repaired. bad_argument for content that no file can
///          hold.
class Writer {
 public:
  /// Writes the beginning of the file. Errors: bad_argument (an option), out_of_memory, io.
  static hal::Result<std::unique_ptr<Writer>> open(std::unique_ptr<hal::OutputFile> file, const WriterOptions& options);
  ~Writer();  // without finish() the file has no summary; readers then scan it

  /// Errors: bad_argument when there are 65535 already.
  hal::Result<std::uint16_t> add_schema(std::string_view name, std::string_view encoding, std::string_view data);
  /// `schema` 0: none. Errors: bad_argument for an unknown schema or when there are 65535 already.
  hal::Result<std::uint16_t> add_channel(std::string_view topic, std::string_view message_encoding,
                                         std::uint16_t schema, const Texts& metadata = {},
                                         Packing packing = Packing::packed);

  hal::Status write(std::uint16_t channel, const Stamps& stamps, std::span<const std::byte> data) {
    return write_parts(channel, stamps, {&data, 1});
  }
  /// One message of up to kMaxParts pieces: the head of an image and its pixels.
  static constexpr std::size_t kMaxParts = 8;
  static constexpr std::uint64_t kMaxDataBytes = 512u << 20;  // of a message or an attachment; readers have limits
  static constexpr std::chrono::milliseconds kRetryAfter{100};
  hal::Status write_parts(std::uint16_t channel, const Stamps& stamps, hal::Parts parts);

  /// First closes the open chunks, so that the file keeps the order of the calls; synced with the next chunk.
  hal::Status attach(const Attachment& attachment);
  /// As attach(), but may also use the free floor: reports of losses must find room.
  hal::Status add_metadata(const Metadata& metadata);

  /// Writes chunks that are older than chunk_duration at `log_time`; call it in times without messages.
  hal::Status tick(std::uint64_t log_time);
  /// Writes what is in memory and syncs.
  hal::Status flush();
  /// Completes the file; may use the free floor. On an error it may be tried again.
  hal::Status finish();
  /// Appends the end of the file and goes on in another one with the same channels. `former` is complete when it has
  /// settled; a file that was finished already is closed. On an error `file` is removed; when it was one in appending
  /// the end, nothing has happened, otherwise the former file has its end, and the writer is in none.
  hal::Status continue_in(std::unique_ptr<hal::OutputFile> file, std::unique_ptr<hal::OutputFile>& former);
  /// Runs `beginning`, which writes the new file's attachments and metadata, no messages. On its error none of them is
  /// in the file.
  hal::Status begin_with(const std::function<hal::Status(Writer&)>& beginning);

  bool is_open() const;  // not finished
  /// Checks that the content of the memory fits above the free floor. Errors: io.
  hal::Status room() const;
  const WriterCounters& counters() const;
  /// Least and greatest log time of this file, messages in memory included; nothing before there is one.
  std::optional<std::uint64_t> first_time() const;
  std::optional<std::uint64_t> last_time() const;
  /// About the size after finish() now, without further compression.
  std::uint64_t bytes_planned() const;
  /// The same, if the content of the memory does not get smaller.
  std::uint64_t bytes_at_most() const;

 private:
  struct State;
  explicit Writer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace sinew::record
