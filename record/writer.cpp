#include "record/writer.hpp"

#include <algorithm>

#include "record/crc32.hpp"
#include "record/writer_state.hpp"

namespace sinew::record {
namespace {

using hal::Errc;
using hal::Error;
using hal::Status;

/// Uncompressed message data from this size on are not copied: the copy costs more than a separate chunk.
constexpr std::size_t kDirectBytes = 64 << 10;

constexpr std::size_t kMaxIds = 65535;

}  // namespace

hal::Result<std::unique_ptr<Writer>> Writer::open(std::unique_ptr<hal::OutputFile> file, const WriterOptions& options) {
  if (options.chunk_bytes < 1024 || options.chunk_bytes > kMaxDataBytes)
    return Error{Errc::bad_argument, "chunk_bytes: 1024 to 2^29", static_cast<std::int64_t>(options.chunk_bytes)};
  if (options.chunk_duration.count() <= 0)
    return Error{Errc::bad_argument, "chunk_duration: more than 0", options.chunk_duration.count()};
  auto packed = Compressor::make(options.compression, options.zstd_level);
  auto plain = Compressor::make(Compression::none, 0);
  if (!packed) return packed.error();
  auto state = std::make_unique<State>(std::move(file), options, std::move(*packed), std::move(*plain));
  if (auto done = state->begin(); !done) return done.error();
  return std::unique_ptr<Writer>(new Writer(std::move(state)));
}

Writer::Writer(std::unique_ptr<State> state) : state_(std::move(state)) {}
Writer::~Writer() = default;

hal::Result<std::uint16_t> Writer::add_schema(std::string_view name, std::string_view encoding, std::string_view data) {
  auto& schemas = state_->summary.schemas;
  if (schemas.size() >= kMaxIds) return Error{Errc::bad_argument, "schemas: at most 65535"};
  const auto id = static_cast<std::uint16_t>(schemas.size() + 1);
  schemas.emplace(id, Schema{id, std::string(name), std::string(encoding), std::string(data)});
  return id;
}

hal::Result<std::uint16_t> Writer::add_channel(std::string_view topic, std::string_view message_encoding,
                                               std::uint16_t schema, const Texts& metadata, Packing packing) {
  auto& s = *state_;
  if (s.channels.size() >= kMaxIds) return Error{Errc::bad_argument, "channels: at most 65535"};
  if (schema != 0 && !s.summary.schemas.contains(schema)) return Error{Errc::bad_argument, "no such schema", schema};
  const auto id = static_cast<std::uint16_t>(s.channels.size() + 1);
  s.summary.channels.emplace(id, Channel{id, schema, std::string(topic), std::string(message_encoding), metadata});
  s.channels.emplace_back().packing = packing;
  return id;
}

Status Writer::write_parts(std::uint16_t id, const Stamps& stamps, hal::Parts parts) {
  auto& s = *state_;
  if (id == 0 || id > s.channels.size()) return Error{Errc::bad_argument, "no such channel", id};
  if (parts.size() > kMaxParts) return Error{Errc::bad_argument, "a message of too many parts: at most 8"};
  if (s.finished) return Error{Errc::closed, "record: the file is finished"};
  std::size_t size = 0;
  for (const auto& part : parts) size += part.size();
  if (size > kMaxDataBytes)
    return Error{Errc::bad_argument, "a message of more than 2^29 bytes", static_cast<std::int64_t>(size)};
  State::ChannelState& channel = s.channels[id - 1u];
  ChunkBuilder& builder = s.builder_of(channel);
  const bool direct = builder.compression() == Compression::none && size >= kDirectBytes;
  const bool full = !direct && builder.size() + kMessageHead + size > s.options.chunk_bytes;
  const bool ended = (full && builder.has_messages()) || s.old(builder, stamps.log_time);
  if ((ended || direct) && s.refused_lately(stamps.log_time)) return *s.refused;
  if (ended)
    if (auto done = s.outcome(s.put_above_floor(builder), stamps.log_time); !done) return done;
  if (!channel.defined) s.define_all(builder);
  if (direct) return s.outcome(s.put_direct(builder, id, stamps, parts, size), stamps.log_time);
  builder.add(id, channel.places, stamps, parts, size);
  return {};
}

Status Writer::attach(const Attachment& attachment) {
  auto& s = *state_;
  if (attachment.data.size() > kMaxDataBytes)
    return Error{Errc::bad_argument, "an attachment of more than 2^29 bytes",
                 static_cast<std::int64_t>(attachment.data.size())};
  if (auto room = s.room_for(s.packed.size() + s.plain.size() + attachment.data.size()); !room) return room;
  if (auto done = s.close_chunks(); !done) return done;
  Buffer bytes;
  encode_head(bytes, attachment, attachment.data.size());
  bytes.append(as_bytes(attachment.data));
  bytes.number(crc32(bytes.bytes().subspan(kRecordHead)));
  const std::uint64_t at = s.end.size();
  if (auto done = s.end.append(bytes.bytes()); !done) {
    ++s.counters.failed_writes;
    return done;
  }
  s.summary.attachments.push_back({at, bytes.size(), attachment.log_time, attachment.create_time,
                                   attachment.data.size(), attachment.name, attachment.media_type});
  s.counters.file_bytes = s.end.size();
  s.unsynced = true;
  return {};
}

Status Writer::add_metadata(const Metadata& metadata) {
  auto& s = *state_;
  if (auto done = s.close_chunks(); !done) return done;
  Buffer bytes;
  encode(bytes, metadata);
  const std::uint64_t at = s.end.size();
  if (auto done = s.end.append(bytes.bytes()); !done) {
    ++s.counters.failed_writes;
    return done;
  }
  s.summary.metadata.push_back({at, bytes.size(), metadata.name});
  s.counters.file_bytes = s.end.size();
  s.unsynced = true;
  return {};
}

Status Writer::tick(std::uint64_t log_time) {
  auto& s = *state_;
  if (s.finished) return Error{Errc::closed, "record: the file is finished"};
  for (ChunkBuilder* builder : {&s.plain, &s.packed})
    if (s.old(*builder, log_time)) {
      if (s.refused_lately(log_time)) return *s.refused;
      if (auto done = s.outcome(s.put_above_floor(*builder), log_time); !done) return done;
    }
  if (s.unsynced && log_time > s.unsynced_since && log_time - s.unsynced_since >= s.duration()) s.sync();
  return {};
}

Status Writer::flush() {
  if (auto room = this->room(); !room) return room;
  if (auto done = state_->close_chunks(); !done) return done;
  state_->sync();
  return {};
}

Status Writer::finish() { return state_->finish(); }

Status Writer::continue_in(std::unique_ptr<hal::OutputFile> file, std::unique_ptr<hal::OutputFile>& former) {
  auto& s = *state_;
  if (!s.finished)
    if (auto done = s.append_end(); !done) {
      static_cast<void>(file->remove());  // so that it can be made again
      return done;
    }
  auto before = s.end.exchange(std::move(file));
  if (!s.finished) former = std::move(before);
  s.finished = s.unused_defined = false;
  for (auto& channel : s.channels) channel.defined = false, channel.messages = 0;
  s.summary.chunks.clear(), s.summary.attachments.clear(), s.summary.metadata.clear();
  s.totals = {}, s.summary_bytes = 0;
  s.refused.reset();
  auto done = s.begin();
  s.finished = !done;  // a file without its beginning takes nothing
  if (!done) static_cast<void>(s.end.file().remove());
  return done;
}

Status Writer::begin_with(const std::function<Status(Writer&)>& beginning) {
  auto& s = *state_;
  const auto size = s.end.size();
  const auto crc = s.end.crc();
  const auto attachments = s.summary.attachments.size(), metadata = s.summary.metadata.size();
  auto done = beginning(*this);
  if (done) return done;
  s.summary.attachments.resize(attachments), s.summary.metadata.resize(metadata);
  if (auto cut = s.end.cut(size, crc); !cut) return cut;
  s.counters.file_bytes = size;
  return done;
}

Status Writer::room() const { return state_->room_for(state_->packed.size() + state_->plain.size()); }

bool Writer::is_open() const { return !state_->finished; }

const WriterCounters& Writer::counters() const { return state_->counters; }

std::optional<std::uint64_t> Writer::first_time() const {
  const auto& s = *state_;
  std::optional<std::uint64_t> first;
  if (s.totals.messages != 0) first = s.totals.start_time;
  for (const ChunkBuilder* builder : {&s.plain, &s.packed})
    if (builder->has_messages()) first = std::min(first.value_or(builder->start_time()), builder->start_time());
  return first;
}

std::optional<std::uint64_t> Writer::last_time() const {
  const auto& s = *state_;
  std::optional<std::uint64_t> last;
  if (s.totals.messages != 0) last = s.totals.end_time;
  for (const ChunkBuilder* builder : {&s.plain, &s.packed})
    if (builder->has_messages()) last = std::max(last.value_or(0), builder->end_time());
  return last;
}

std::uint64_t Writer::bytes_planned() const {
  const auto& s = *state_;
  return s.end.size() + s.packed.size() + s.plain.size() + s.summary_bytes;
}

std::uint64_t Writer::bytes_at_most() const {
  const auto& s = *state_;
  return s.end.size() + State::most_of(s.packed.size()) + State::most_of(s.plain.size()) + s.summary_bytes;
}

}  // namespace sinew::record
