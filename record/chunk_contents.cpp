#include "record/chunk_contents.hpp"

#include "record/crc32.hpp"

namespace sinew::record {
namespace {

std::string number_text(std::uint64_t value) { return std::to_string(value); }

}  // namespace

bool read_bytes(hal::InputFile& file, std::uint64_t offset, std::uint64_t length, const ReadLimits& limits, Buffer& to,
                FileProblem& problem) {
  if (length > file.size() || offset > file.size() - length) {
    problem = {ProblemKind::truncated, offset,
               number_text(length) + " bytes wanted, the file has " + number_text(file.size()) + " in all"};
    return false;
  }
  if (length > limits.record_bytes) {
    problem = {ProblemKind::too_large, offset,
               number_text(length) + " bytes; this reader takes " + number_text(limits.record_bytes)};
    return false;
  }
  to.resize(static_cast<std::size_t>(length));
  if (auto done = file.read_at(offset, {to.data(), to.size()}); !done) {
    problem = {ProblemKind::io, offset,
               std::string(done.error().where) + ", error " + number_text(done.error().detail)};
    return false;
  }
  return true;
}

bool take_record(std::span<const std::byte>& rest, Op& op, std::span<const std::byte>& content) {
  Cursor cursor(rest);
  op = static_cast<Op>(cursor.number<std::uint8_t>());
  content = cursor.take(cursor.number<std::uint64_t>());
  rest = cursor.rest();
  return cursor.good();
}

bool ChunkContents::load(hal::InputFile& file, const Block& block, const ReadLimits& limits, Decompressor& decompressor,
                         FileProblem& problem) {
  head_.reset(), records_ = {};
  entries_.clear(), schemas_.clear(), channels_.clear();
  start_time_ = end_time_ = 0;
  if (!read_bytes(file, block.offset, block.length, limits, stored_, problem)) return false;
  if (block.loose)
    records_ = stored_.bytes();
  else if (!unpack(block, limits, decompressor, problem))
    return false;
  if (!take_apart(block, problem)) return false;
  if (block.judged && !entries_.empty() && (start_time_ != block.start_time || end_time_ != block.end_time)) {
    problem = {ProblemKind::bad_index, block.offset,
               "messages from " + number_text(start_time_) + " to " + number_text(end_time_) +
                   ", the index says from " + number_text(block.start_time) + " to " + number_text(block.end_time)};
    return false;
  }
  return true;
}

bool ChunkContents::unpack(const Block& block, const ReadLimits& limits, Decompressor& decompressor,
                           FileProblem& problem) {
  Cursor cursor(stored_.bytes());
  const auto op = static_cast<Op>(cursor.number<std::uint8_t>());
  const auto length = cursor.number<std::uint64_t>();
  if (op != Op::chunk || length != cursor.rest().size()) {
    problem = {ProblemKind::bad_index, block.offset, "no chunk of " + number_text(block.length) + " bytes is here"};
    return false;
  }
  std::span<const std::byte> packed;
  if (!decode(cursor.rest(), head_.emplace(), packed)) {
    problem = {ProblemKind::bad_record, block.offset, "the fields of the chunk are longer than the chunk"};
    return false;
  }
  const auto compression = compression_named(head_->compression);
  if (!compression) {
    problem = {ProblemKind::bad_compression, block.offset,
               "'" + head_->compression.substr(0, 32) + "'; known are '' (none), 'lz4' and 'zstd'"};
    return false;
  }
  if (*compression == Compression::none && head_->uncompressed_size == packed.size()) {
    records_ = packed;
  } else {
    if (head_->uncompressed_size > limits.record_bytes) {
      problem = {
          ProblemKind::too_large, block.offset,
          number_text(head_->uncompressed_size) + " bytes; this reader takes " + number_text(limits.record_bytes)};
      return false;
    }
    // No frame of lz4 grows more than 255 times: a frame that claims more is not worth the memory.
    if (*compression == Compression::lz4 && head_->uncompressed_size / 256 > packed.size()) {
      problem = {ProblemKind::bad_compression, block.offset, "an lz4 frame cannot hold so much"};
      return false;
    }
    unpacked_.resize(static_cast<std::size_t>(head_->uncompressed_size));
    if (auto done = decompressor.decompress(*compression, packed, {unpacked_.data(), unpacked_.size()}); !done) {
      problem = {ProblemKind::bad_compression, block.offset, done.error().where};
      return false;
    }
    records_ = unpacked_.bytes();
  }
  if (head_->uncompressed_crc != 0 && crc32(records_) != head_->uncompressed_crc) {
    problem = {ProblemKind::bad_checksum, block.offset, "the chunk's bytes are not those that were written"};
    return false;
  }
  return true;
}

bool ChunkContents::take_apart(const Block& block, FileProblem& problem) {
  Cursor cursor(records_);
  const auto bad = [&](std::uint64_t place, const char* what) {
    problem = {ProblemKind::bad_record, block.loose ? block.offset + place : block.offset,
               block.loose ? what : "at " + number_text(place) + " of the uncompressed chunk: " + what};
    return false;
  };
  while (!cursor.rest().empty()) {
    const std::uint64_t place = records_.size() - cursor.rest().size();
    const auto op = static_cast<Op>(cursor.number<std::uint8_t>());
    const auto length = cursor.number<std::uint64_t>();
    const auto content = cursor.take(length);
    if (!cursor.good()) return bad(place, "a record reaches beyond the end");
    if (op == Op::message) {
      if (content.size() < kMessageHead - kRecordHead) return bad(place, "a message is shorter than its head");
      Cursor fields(content);
      Entry entry{.log_time = 0, .place = place, .size = kRecordHead + length, .channel = 0};
      entry.channel = fields.number<std::uint16_t>();
      static_cast<void>(fields.number<std::uint32_t>());
      entry.log_time = fields.number<std::uint64_t>();
      start_time_ = entries_.empty() ? entry.log_time : std::min(start_time_, entry.log_time);
      end_time_ = std::max(end_time_, entry.log_time);
      entries_.push_back(entry);
    } else if (op == Op::schema) {
      if (!decode(content, schemas_.emplace_back())) return bad(place, "the fields of a schema are longer than it");
    } else if (op == Op::channel) {
      if (!decode(content, channels_.emplace_back())) return bad(place, "the fields of a channel are longer than it");
    }  // anything else is skipped, as the format wants it
  }
  return true;
}

void ChunkContents::message(const Entry& entry, Stamps& stamps, std::span<const std::byte>& data) const {
  Cursor fields(records_.subspan(static_cast<std::size_t>(entry.place) + kRecordHead + 2,
                                 static_cast<std::size_t>(entry.size) - kRecordHead - 2));
  stamps.sequence = fields.number<std::uint32_t>();
  stamps.log_time = fields.number<std::uint64_t>();
  stamps.publish_time = fields.number<std::uint64_t>();
  data = fields.rest();
}

bool merge_definitions(const std::vector<Schema>& schemas, const std::vector<Channel>& channels, std::uint64_t offset,
                       Summary& known, FileProblem& problem) {
  for (const Schema& schema : schemas) {
    if (schema.id == 0) continue;  // invalid, to be ignored
    if (known.schemas.emplace(schema.id, schema).first->second != schema) {
      problem = {ProblemKind::bad_record, offset, "schema " + number_text(schema.id) + " is not what it was before"};
      return false;
    }
  }
  for (const Channel& channel : channels) {
    if (channel.schema != 0 && !known.schemas.contains(channel.schema)) {
      problem = {
          ProblemKind::unknown_channel, offset,
          "channel " + number_text(channel.id) + " has schema " + number_text(channel.schema) + ", not defined before"};
      return false;
    }
    if (known.channels.emplace(channel.id, channel).first->second != channel) {
      problem = {ProblemKind::bad_record, offset, "channel " + number_text(channel.id) + " is not what it was before"};
      return false;
    }
  }
  return true;
}

}  // namespace sinew::record
