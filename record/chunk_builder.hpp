#pragma once
#include <memory>
#include <vector>

#include "hal/file.hpp"
#include "record/compression.hpp"
#include "record/format.hpp"

namespace sinew::record {

/// The places of one channel's messages in the chunk that is being made.
struct ChannelPlaces {
  Buffer entries;  // (log time, place), as in a message index
  std::uint64_t count() const { return entries.size() / 16; }
};

/// A chunk in memory.
/// Thread:  owner.
class ChunkBuilder {
 public:
  explicit ChunkBuilder(std::unique_ptr<Compressor> compressor, Compression compression)
      : compressor_(std::move(compressor)), compression_(compression) {}
  void reserve(std::size_t bytes) { records_.reserve(bytes); }
  bool empty() const { return records_.empty(); }
  bool has_messages() const { return !channels_.empty(); }
  std::size_t size() const { return records_.size(); }
  Compression compression() const { return compression_; }
  std::uint64_t first_time() const { return first_time_; }  // of the first message that came
  std::uint64_t start_time() const { return start_time_; }
  std::uint64_t end_time() const { return end_time_; }
  const std::vector<std::uint16_t>& channels() const { return channels_; }  // with messages, in order of arrival

  template <class Definition>
  void define(const Definition& record) {
    encode(records_, record);
    sealed_ = false;
  }
  void add(std::uint16_t channel, ChannelPlaces& places, const Stamps& stamps, hal::Parts parts, std::size_t size) {
    add_head(channel, places, stamps, size);
    std::byte* to = records_.extend(size);
    for (const auto& part : parts) {
      if (!part.empty()) std::memcpy(to, part.data(), part.size());
      to += part.size();
    }
  }
  /// The message's data will be written behind the chunk, from their own place: see seal(). drop_head() takes the head
  /// back.
  void add_head(std::uint16_t channel, ChannelPlaces& places, const Stamps& stamps, std::size_t size);
  struct Times {
    std::uint64_t first, start, end;
  };
  Times times() const { return {first_time_, start_time_, end_time_}; }
  void drop_head(ChannelPlaces& places, const Times& before);

  /// The parts of a chunk record; some of them lie in the builder.
  struct Sealed {
    ChunkHead head;
    std::span<const std::byte> records;  // as they go to the file; the tail follows them
    std::uint32_t stored_crc = 0;        // of both
  };
  /// `tail`: the data of the last message, of `tail_size` bytes, if they are not in the builder; never compressed.
  /// Errors:  out_of_memory; the builder is as before.
  hal::Result<Sealed> seal(hal::Parts tail, std::size_t tail_size);
  /// Starts the next chunk; the owner of the channels' places clears them before.
  void clear();

 private:
  std::unique_ptr<Compressor> compressor_;
  Compression compression_;
  Buffer records_, packed_;
  bool sealed_ = false;  // packed_ and the sums belong to records_
  std::uint32_t crc_ = 0, packed_crc_ = 0;
  std::uint64_t first_time_ = 0, start_time_ = 0, end_time_ = 0;
  std::vector<std::uint16_t> channels_;
};

}  // namespace sinew::record
