#include "record/format.hpp"

#include "record/crc32.hpp"

namespace sinew::record {
namespace {

using U16 = std::uint16_t;
using U32 = std::uint32_t;
using U64 = std::uint64_t;
using Bytes = std::span<const std::byte>;

/// One record around the fields that are appended while it lives.
class Record {
 public:
  Record(Buffer& to, Op op) : to_(to) {
    to.number(static_cast<std::uint8_t>(op));
    at_ = to.begin_length<U64>();
  }
  ~Record() { to_.end_length<U64>(at_); }
  Record(const Record&) = delete;
  Record& operator=(const Record&) = delete;

 private:
  Buffer& to_;
  std::size_t at_;
};

void put_counts(Buffer& to, const std::map<U16, U64>& map) {
  to.number(static_cast<U32>(map.size() * 10));
  for (const auto& [key, value] : map) to.number(key), to.number(value);
}

std::map<U16, U64> take_counts(Cursor& from, bool& good) {
  Cursor inside(from.take(from.number<U32>()));
  std::map<U16, U64> map;
  while (inside.good() && !inside.rest().empty()) {
    const U16 key = inside.number<U16>();
    const U64 value = inside.number<U64>();
    if (inside.good()) map.insert_or_assign(key, value);
  }
  good = good && inside.good();
  return map;
}

}  // namespace

const char* to_string(Compression compression) {
  switch (compression) {
    case Compression::lz4:
      return "lz4";
    case Compression::zstd:
      return "zstd";
    case Compression::none:
      break;
  }
  return "";
}

std::optional<Compression> compression_named(std::string_view name) {
  for (const auto c : {Compression::none, Compression::lz4, Compression::zstd})
    if (name == to_string(c)) return c;
  return {};
}

void encode(Buffer& to, const Header& r) {
  const Record record(to, Op::header);
  to.text(r.profile), to.text(r.library);
}
void encode(Buffer& to, const Schema& r) {
  const Record record(to, Op::schema);
  to.number(r.id), to.text(r.name), to.text(r.encoding), to.text(r.data);
}
void encode(Buffer& to, const Channel& r) {
  const Record record(to, Op::channel);
  to.number(r.id), to.number(r.schema), to.text(r.topic), to.text(r.message_encoding), to.texts(r.metadata);
}
void encode(Buffer& to, const ChunkIndex& r) {
  const Record record(to, Op::chunk_index);
  to.number(r.start_time), to.number(r.end_time), to.number(r.offset), to.number(r.length);
  put_counts(to, r.message_indexes);
  to.number(r.message_index_length), to.text(r.compression);
  to.number(r.compressed_size), to.number(r.uncompressed_size);
}
void encode(Buffer& to, const AttachmentIndex& r) {
  const Record record(to, Op::attachment_index);
  to.number(r.offset), to.number(r.length), to.number(r.log_time), to.number(r.create_time), to.number(r.data_size);
  to.text(r.name), to.text(r.media_type);
}
void encode(Buffer& to, const Metadata& r) {
  const Record record(to, Op::metadata);
  to.text(r.name), to.texts(r.values);
}
void encode(Buffer& to, const MetadataIndex& r) {
  const Record record(to, Op::metadata_index);
  to.number(r.offset), to.number(r.length), to.text(r.name);
}
void encode(Buffer& to, const Statistics& r) {
  const Record record(to, Op::statistics);
  to.number(r.messages), to.number(r.schemas), to.number(r.channels), to.number(r.attachments);
  to.number(r.metadata), to.number(r.chunks), to.number(r.start_time), to.number(r.end_time);
  put_counts(to, r.channel_messages);
}
void encode(Buffer& to, const SummaryOffset& r) {
  const Record record(to, Op::summary_offset);
  to.number(static_cast<std::uint8_t>(r.group)), to.number(r.start), to.number(r.length);
}

void encode_head(Buffer& to, const ChunkHead& r) {
  to.number(static_cast<std::uint8_t>(Op::chunk));
  to.number(U64{8 + 8 + 8 + 4 + 4 + 8} + r.compression.size() + r.records_size);
  to.number(r.start_time), to.number(r.end_time), to.number(r.uncompressed_size), to.number(r.uncompressed_crc);
  to.text(r.compression), to.number(r.records_size);
}
void encode_head(Buffer& to, const Attachment& r, U64 data_size) {
  to.number(static_cast<std::uint8_t>(Op::attachment));
  to.number(U64{8 + 8 + 4 + 4 + 8 + 4} + r.name.size() + r.media_type.size() + data_size);
  to.number(r.log_time), to.number(r.create_time), to.text(r.name), to.text(r.media_type), to.number(data_size);
}

bool decode(Bytes content, Header& r) {
  Cursor c(content);
  r.profile = c.text(), r.library = c.text();
  return c.good();
}
bool decode(Bytes content, Footer& r) {
  Cursor c(content);
  r.summary_start = c.number<U64>(), r.summary_offset_start = c.number<U64>(), r.summary_crc = c.number<U32>();
  return c.good();
}
bool decode(Bytes content, Schema& r) {
  Cursor c(content);
  r.id = c.number<U16>(), r.name = c.text(), r.encoding = c.text(), r.data = c.text();
  return c.good();
}
bool decode(Bytes content, Channel& r) {
  Cursor c(content);
  r.id = c.number<U16>(), r.schema = c.number<U16>(), r.topic = c.text(), r.message_encoding = c.text();
  r.metadata = c.texts();
  return c.good();
}
bool decode(Bytes content, ChunkIndex& r) {
  Cursor c(content);
  bool good = true;
  r.start_time = c.number<U64>(), r.end_time = c.number<U64>(), r.offset = c.number<U64>();
  r.length = c.number<U64>(), r.message_indexes = take_counts(c, good), r.message_index_length = c.number<U64>();
  r.compression = c.text(), r.compressed_size = c.number<U64>(), r.uncompressed_size = c.number<U64>();
  return good && c.good();
}
bool decode(Bytes content, AttachmentIndex& r) {
  Cursor c(content);
  r.offset = c.number<U64>(), r.length = c.number<U64>(), r.log_time = c.number<U64>();
  r.create_time = c.number<U64>(), r.data_size = c.number<U64>(), r.name = c.text(), r.media_type = c.text();
  return c.good();
}
bool decode(Bytes content, Metadata& r) {
  Cursor c(content);
  r.name = c.text(), r.values = c.texts();
  return c.good();
}
bool decode(Bytes content, MetadataIndex& r) {
  Cursor c(content);
  r.offset = c.number<U64>(), r.length = c.number<U64>(), r.name = c.text();
  return c.good();
}
bool decode(Bytes content, Statistics& r) {
  Cursor c(content);
  bool good = true;
  r.messages = c.number<U64>(), r.schemas = c.number<U16>(), r.channels = c.number<U32>();
  r.attachments = c.number<U32>(), r.metadata = c.number<U32>(), r.chunks = c.number<U32>();
  r.start_time = c.number<U64>(), r.end_time = c.number<U64>(), r.channel_messages = take_counts(c, good);
  return good && c.good();
}
bool decode(Bytes content, SummaryOffset& r) {
  Cursor c(content);
  r.group = static_cast<Op>(c.number<std::uint8_t>()), r.start = c.number<U64>(), r.length = c.number<U64>();
  return c.good();
}
bool decode(Bytes content, ChunkHead& r, Bytes& records) {
  Cursor c(content);
  r.start_time = c.number<U64>(), r.end_time = c.number<U64>(), r.uncompressed_size = c.number<U64>();
  r.uncompressed_crc = c.number<U32>(), r.compression = c.text(), r.records_size = c.number<U64>();
  records = c.take(r.records_size);
  return c.good();
}
bool decode(Bytes content, Attachment& r, U32& crc, U32& crc_computed) {
  Cursor c(content);
  r.log_time = c.number<U64>(), r.create_time = c.number<U64>(), r.name = c.text(), r.media_type = c.text();
  r.data = as_text(c.take(c.number<U64>()));
  if (!c.good()) return false;
  crc_computed = crc32(content.first(content.size() - c.rest().size()));
  crc = c.number<U32>();
  return c.good();
}

}  // namespace sinew::record
