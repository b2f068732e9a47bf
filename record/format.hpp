#pragma once
// The records of an MCAP file as values, and their bytes: little-endian (buffer.hpp).
// Source:  "MCAP File Format Specification", major version 0 (mcap.dev/spec); the tables of its section "Records".
#include <array>
#include <map>
#include <optional>
#include <string>

#include "record/buffer.hpp"

namespace sinew::record {

inline constexpr std::array<std::byte, 8> kMagic = {std::byte{0x89}, std::byte{'M'}, std::byte{'C'},  std::byte{'A'},
                                                    std::byte{'P'},  std::byte{'0'}, std::byte{'\r'}, std::byte{'\n'}};

/// The kind of a record; records of other kinds are skipped.
enum class Op : std::uint8_t {
  header = 0x01,
  footer = 0x02,
  schema = 0x03,
  channel = 0x04,
  message = 0x05,
  chunk = 0x06,
  message_index = 0x07,
  chunk_index = 0x08,
  attachment = 0x09,
  attachment_index = 0x0A,
  statistics = 0x0B,
  metadata = 0x0C,
  metadata_index = 0x0D,
  summary_offset = 0x0E,
  data_end = 0x0F,
};

inline constexpr std::size_t kRecordHead = 9;                             // op and u64 length
inline constexpr std::size_t kMessageHead = kRecordHead + 2 + 4 + 8 + 8;  // before the data
inline constexpr std::size_t kFooterBytes = kRecordHead + 8 + 8 + 4;
inline constexpr std::size_t kFileTail = kFooterBytes + kMagic.size();

enum class Compression : std::uint8_t { none, lz4, zstd };
const char* to_string(Compression compression);  // as in the file: "", "lz4", "zstd"
std::optional<Compression> compression_named(std::string_view name);

struct Header {
  std::string profile, library;
};
struct Schema {
  std::uint16_t id = 0;
  std::string name, encoding, data;
  friend bool operator==(const Schema&, const Schema&) = default;
};
struct Channel {
  std::uint16_t id = 0, schema = 0;  // schema 0: none
  std::string topic, message_encoding;
  Texts metadata;
  friend bool operator==(const Channel&, const Channel&) = default;
};
/// A message's fields besides its data. Units: nanoseconds since an origin of the file's own.
struct Stamps {
  std::uint32_t sequence = 0;
  std::uint64_t log_time = 0, publish_time = 0;
  friend bool operator==(const Stamps&, const Stamps&) = default;
};
struct ChunkHead {
  std::uint64_t start_time = 0, end_time = 0;  // zero when it has no messages
  std::uint64_t uncompressed_size = 0;
  std::uint32_t uncompressed_crc = 0;  // zero: not available
  std::string compression;
  std::uint64_t records_size = 0;  // as in the file
};
struct ChunkIndex {
  std::uint64_t start_time = 0, end_time = 0;
  std::uint64_t offset = 0, length = 0;                    // of the whole chunk record
  std::map<std::uint16_t, std::uint64_t> message_indexes;  // by channel: where in the file
  std::uint64_t message_index_length = 0;
  std::string compression;
  std::uint64_t compressed_size = 0, uncompressed_size = 0;
};
struct Attachment {
  std::uint64_t log_time = 0, create_time = 0;
  std::string name, media_type, data;
};
struct AttachmentIndex {
  std::uint64_t offset = 0, length = 0, log_time = 0, create_time = 0, data_size = 0;
  std::string name, media_type;
  friend bool operator==(const AttachmentIndex&, const AttachmentIndex&) = default;
};
struct Metadata {
  std::string name;
  Texts values;
};
struct MetadataIndex {
  std::uint64_t offset = 0, length = 0;
  std::string name;
  friend bool operator==(const MetadataIndex&, const MetadataIndex&) = default;
};
struct Statistics {
  std::uint64_t messages = 0;
  std::uint16_t schemas = 0;
  std::uint32_t channels = 0, attachments = 0, metadata = 0, chunks = 0;
  std::uint64_t start_time = 0, end_time = 0;
  std::map<std::uint16_t, std::uint64_t> channel_messages;
  friend bool operator==(const Statistics&, const Statistics&) = default;
};
struct SummaryOffset {
  Op group = Op::schema;
  std::uint64_t start = 0, length = 0;
};
struct Footer {
  std::uint64_t summary_start = 0, summary_offset_start = 0;
  std::uint32_t summary_crc = 0;
};

// Whole records, head included, at the end of `to`.
void encode(Buffer& to, const Header& record);
void encode(Buffer& to, const Schema& record);
void encode(Buffer& to, const Channel& record);
void encode(Buffer& to, const ChunkIndex& record);
void encode(Buffer& to, const AttachmentIndex& record);
void encode(Buffer& to, const Metadata& record);
void encode(Buffer& to, const MetadataIndex& record);
void encode(Buffer& to, const Statistics& record);
void encode(Buffer& to, const SummaryOffset& record);
/// Up to the beginning of the records inside.
void encode_head(Buffer& to, const ChunkHead& record);
/// Up to the beginning of the data; the caller appends the crc that ends the record.
void encode_head(Buffer& to, const Attachment& record, std::uint64_t data_size);
inline void encode_message_head(std::byte* to, std::uint16_t channel, const Stamps& stamps, std::uint64_t data_size) {
  to[0] = static_cast<std::byte>(Op::message);
  Buffer::put(to + 1, kMessageHead - kRecordHead + data_size);
  Buffer::put(to + 9, channel);
  Buffer::put(to + 11, stamps.sequence);
  Buffer::put(to + 15, stamps.log_time);
  Buffer::put(to + 23, stamps.publish_time);
}

// From the content behind a record's head. False: it is shorter than its fields say. Bytes behind the last known field
// are ignored, as the format wants it.
bool decode(std::span<const std::byte> content, Header& record);
bool decode(std::span<const std::byte> content, Footer& record);
bool decode(std::span<const std::byte> content, Schema& record);
bool decode(std::span<const std::byte> content, Channel& record);
bool decode(std::span<const std::byte> content, ChunkIndex& record);
bool decode(std::span<const std::byte> content, AttachmentIndex& record);
bool decode(std::span<const std::byte> content, Metadata& record);
bool decode(std::span<const std::byte> content, MetadataIndex& record);
bool decode(std::span<const std::byte> content, Statistics& record);
bool decode(std::span<const std::byte> content, SummaryOffset& record);
/// `records`: the chunk's records, compressed as in the file.
bool decode(std::span<const std::byte> content, ChunkHead& record, std::span<const std::byte>& records);
bool decode(std::span<const std::byte> content, Attachment& record, std::uint32_t& crc, std::uint32_t& crc_computed);

}  // namespace sinew::record
