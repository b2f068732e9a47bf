#pragma once
#include "record/chunk_builder.hpp"
#include "record/file_end.hpp"
#include "record/summary.hpp"
#include "record/writer.hpp"

namespace sinew::record {

/// The inside of a Writer: the file, the two chunks in memory, and the content of the summary.
/// Thread:  owner.
struct Writer::State {
  using Status = hal::Status;

  WriterOptions options;
  FileEnd end;
  ChunkBuilder packed, plain;
  struct ChannelState {
    Packing packing = Packing::packed;
    bool defined = false;  // its record is in a chunk of this file
    ChannelPlaces places;
    std::uint64_t messages = 0;  // in chunks of this file
  };
  std::vector<ChannelState> channels;  // channel 1 first
  Summary summary;
  Statistics totals;
  WriterCounters counters;
  Buffer head, indexes;  // of the chunk that is being written
  bool finished = false, unsynced = false;
  bool unused_defined = false;
  std::uint64_t data_size = 0;        // of the file without what comes after its data
  std::uint32_t data_crc = 0;         // of those
  std::uint64_t unsynced_since = 0;   // log time
  std::uint64_t summary_bytes = 0;    // of chunk indexes so far
  std::optional<hal::Error> refused;  // why the last chunk is not in the file
  std::uint64_t refused_at = 0;       // log time

  State(std::unique_ptr<hal::OutputFile> file, const WriterOptions& o, std::unique_ptr<Compressor> for_packed,
        std::unique_ptr<Compressor> for_plain)
      : options(o),
        end(std::move(file)),
        packed(std::move(for_packed), o.compression),
        plain(std::move(for_plain), Compression::none) {
    packed.reserve(o.chunk_bytes);
  }

  std::uint64_t duration() const { return static_cast<std::uint64_t>(options.chunk_duration.count()); }
  ChunkBuilder& builder_of(const ChannelState& channel) { return channel.packing == Packing::plain ? plain : packed; }
  bool old(const ChunkBuilder& builder, std::uint64_t now) const {
    return builder.has_messages() && now > builder.first_time() && now - builder.first_time() >= duration();
  }

  /// True if the disk has just refused: a try for every message would delay all of them.
  bool refused_lately(std::uint64_t now) const {
    return refused && now >= refused_at &&
           now - refused_at < std::uint64_t{std::chrono::nanoseconds(kRetryAfter).count()};
  }
  /// Stores the result of a chunk at this time, for refused_lately().
  Status outcome(Status done, std::uint64_t now) {
    refused.reset();
    if (!done) refused = done.error(), refused_at = now;
    return done;
  }

  Status begin();
  /// Writes a builder's chunk and its message indexes, and adds them to the summary.
  Status put(ChunkBuilder& builder, hal::Parts tail, std::size_t tail_size, bool to_disk);
  void note_chunk(ChunkBuilder& builder, const ChunkBuilder::Sealed& chunk, std::uint64_t at);
  /// Writes a chunk with the messages so far and this one, whose data are not copied.
  Status put_direct(ChunkBuilder& builder, std::uint16_t id, const Stamps& stamps, hal::Parts parts, std::size_t size);
  /// The largest size of a chunk of so many bytes of messages in the file, with its indexes: those have 16 bytes for
  /// each message of 31 and more; nothing else grows.
  static std::uint64_t most_of(std::uint64_t bytes) { return bytes + bytes / 2 + 4096; }
  /// Checks that a chunk of so many bytes of messages leaves the free floor.
  Status room_for(std::uint64_t bytes);
  Status put_above_floor(ChunkBuilder& builder) {
    auto room = room_for(builder.size());
    return room ? put(builder, {}, 0, true) : room;
  }
  /// Writes all channels of the builder, so that a cut-off file still names the silent ones.
  void define_all(ChunkBuilder& builder);
  /// The data must define every schema of the summary.
  void define_unused_schemas();
  void sync();
  Status close_chunks();
  /// Appends all that a whole file has at its end, and asks for it to be synced.
  Status append_end();
  Status finish();
};

}  // namespace sinew::record
