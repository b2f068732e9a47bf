#include "record/chunk_builder.hpp"

#include "record/crc32.hpp"

namespace sinew::record {

void ChunkBuilder::add_head(std::uint16_t channel, ChannelPlaces& places, const Stamps& stamps, std::size_t size) {
  if (channels_.empty()) {
    first_time_ = start_time_ = end_time_ = stamps.log_time;
  } else {
    start_time_ = std::min(start_time_, stamps.log_time);
    end_time_ = std::max(end_time_, stamps.log_time);
  }
  if (places.entries.empty()) channels_.push_back(channel);
  std::byte* entry = places.entries.extend(16);
  Buffer::put(entry, stamps.log_time);
  Buffer::put(entry + 8, std::uint64_t{records_.size()});
  encode_message_head(records_.extend(kMessageHead), channel, stamps, size);
  sealed_ = false;
}

void ChunkBuilder::drop_head(ChannelPlaces& places, const Times& before) {
  records_.resize(records_.size() - kMessageHead);
  places.entries.resize(places.entries.size() - 16);
  if (places.entries.empty()) channels_.pop_back();
  first_time_ = before.first, start_time_ = before.start, end_time_ = before.end;
}

hal::Result<ChunkBuilder::Sealed> ChunkBuilder::seal(hal::Parts tail, std::size_t tail_size) {
  if (!sealed_) {
    crc_ = packed_crc_ = crc32(records_.bytes());
    if (compression_ != Compression::none) {
      if (auto done = compressor_->compress(records_.bytes(), packed_); !done) return done.error();
      packed_crc_ = crc32(packed_.bytes());
    }
    sealed_ = true;
  }
  Sealed chunk;
  chunk.head = {start_time_, end_time_, records_.size() + tail_size, crc_, to_string(compression_), 0};
  if (!has_messages()) chunk.head.start_time = chunk.head.end_time = 0;
  chunk.records = compression_ == Compression::none ? records_.bytes() : packed_.bytes();
  chunk.head.records_size = chunk.records.size() + tail_size;
  chunk.stored_crc = packed_crc_;
  for (const auto& part : tail) {
    chunk.stored_crc = crc32(part, chunk.stored_crc);
    chunk.head.uncompressed_crc = chunk.stored_crc;
  }
  return chunk;
}

void ChunkBuilder::clear() {
  records_.clear(), channels_.clear();
  sealed_ = false;
}

}  // namespace sinew::record
