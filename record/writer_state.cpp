#include "record/writer_state.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <set>

#include "record/crc32.hpp"

namespace sinew::record {

using hal::Errc;
using hal::Error;
using hal::Status;

Status Writer::State::begin() {
  head.clear();
  head.append(kMagic);
  encode(head, Header{options.profile, options.library});
  if (auto done = end.append(head.bytes()); !done) return done;
  counters.file_bytes = end.size();
  return {};
}

void Writer::State::define_all(ChunkBuilder& builder) {
  std::set<std::uint16_t> schemas;  // of several channels
  for (std::uint16_t id = 1; id <= channels.size(); ++id) {
    ChannelState& channel = channels[id - 1u];
    if (channel.defined || &builder_of(channel) != &builder) continue;
    const Channel& record = summary.channels.at(id);
    // A schema may be written twice, once for each builder: the order of their chunks is not known yet.
    if (record.schema != 0 && schemas.insert(record.schema).second) builder.define(summary.schemas.at(record.schema));
    builder.define(record);
    channel.defined = true;
  }
}

void Writer::State::define_unused_schemas() {
  if (std::exchange(unused_defined, true)) return;
  std::set<std::uint16_t> used;
  for (const auto& [id, channel] : summary.channels) used.insert(channel.schema);
  for (const auto& [id, schema] : summary.schemas)
    if (!used.contains(id)) packed.define(schema);
}

Status Writer::State::room_for(std::uint64_t bytes) {
  if (options.free_floor_bytes == 0) return {};
  const auto free = end.file().free_bytes();
  if (!free) return free.error();
  const std::uint64_t most = most_of(bytes);
  if (*free < most || *free - most < options.free_floor_bytes)
    return Error{Errc::io, "record: the disk is full up to its free floor", ENOSPC};
  return {};
}

void Writer::State::sync() {
  if (!end.file().sync()) ++counters.failed_syncs;
  unsynced = false;
}

Status Writer::State::put(ChunkBuilder& builder, hal::Parts tail, std::size_t tail_size, bool to_disk) {
  auto chunk = builder.seal(tail, tail_size);
  if (!chunk) return chunk.error();
  head.clear(), indexes.clear();
  encode_head(head, chunk->head);
  for (const std::uint16_t id : builder.channels()) {
    const auto entries = channels[id - 1u].places.entries.bytes();
    indexes.number(static_cast<std::uint8_t>(Op::message_index));
    indexes.number(std::uint64_t{2 + 4} + entries.size());
    indexes.number(id), indexes.number(static_cast<std::uint32_t>(entries.size()));
    indexes.append(entries);
  }
  std::array<std::span<const std::byte>, 3 + kMaxParts> parts;
  std::size_t count = 0;
  parts[count++] = head.bytes(), parts[count++] = chunk->records;
  for (const auto& part : tail) parts[count++] = part;
  parts[count++] = indexes.bytes();
  std::uint32_t crc = crc32_joined(crc32(head.bytes(), end.crc()), chunk->stored_crc, chunk->head.records_size);
  crc = crc32(indexes.bytes(), crc);

  const std::uint64_t at = end.size();
  if (auto done = end.append({parts.data(), count}, crc); !done) {
    ++counters.failed_writes;
    return done;
  }
  note_chunk(builder, *chunk, at);
  builder.clear();
  unsynced = true;
  if (to_disk) sync();
  return {};
}

void Writer::State::note_chunk(ChunkBuilder& builder, const ChunkBuilder::Sealed& chunk, std::uint64_t at) {
  ChunkIndex index{.start_time = chunk.head.start_time,
                   .end_time = chunk.head.end_time,
                   .offset = at,
                   .length = head.size() + chunk.head.records_size,
                   .message_indexes = {},
                   .message_index_length = indexes.size(),
                   .compression = chunk.head.compression,
                   .compressed_size = chunk.head.records_size,
                   .uncompressed_size = chunk.head.uncompressed_size};
  std::uint64_t place = at + index.length;
  if (builder.has_messages()) {
    totals.start_time = totals.messages == 0 ? index.start_time : std::min(totals.start_time, index.start_time);
    totals.end_time = std::max(totals.end_time, index.end_time);
  }
  for (const std::uint16_t id : builder.channels()) {
    ChannelState& channel = channels[id - 1u];
    index.message_indexes.emplace(id, place);
    place += kRecordHead + 2 + 4 + channel.places.entries.size();
    channel.messages += channel.places.count();
    totals.messages += channel.places.count(), counters.messages += channel.places.count();
    channel.places.entries.clear();
  }
  summary_bytes += 77 + 10 * index.message_indexes.size();
  summary.chunks.push_back(std::move(index));
  ++counters.chunks;
  counters.file_bytes = end.size();
}

Status Writer::State::put_direct(ChunkBuilder& builder, std::uint16_t id, const Stamps& stamps, hal::Parts parts,
                                 std::size_t size) {
  if (auto room = room_for(builder.size() + size); !room) return room;
  ChannelPlaces& places = channels[id - 1u].places;
  const ChunkBuilder::Times before = builder.times();
  builder.add_head(id, places, stamps, size);
  if (!unsynced) unsynced_since = stamps.log_time;
  const bool waited = stamps.log_time > unsynced_since && stamps.log_time - unsynced_since >= duration();
  auto done = put(builder, parts, size, waited);
  if (!done) builder.drop_head(places, before);
  return done;
}

Status Writer::State::close_chunks() {
  if (finished) return Error{Errc::closed, "record: the file is finished"};
  for (ChunkBuilder* builder : {&plain, &packed})
    if (!builder->empty())
      if (auto done = put(*builder, {}, 0, false); !done) return done;
  return {};
}

Status Writer::State::append_end() {
  if (finished) return Error{Errc::closed, "record: the file is finished"};
  for (ChunkBuilder* builder : {&plain, &packed}) define_all(*builder);
  define_unused_schemas();
  if (auto done = close_chunks(); !done) return done;
  Statistics& s = totals;
  s.schemas = static_cast<std::uint16_t>(summary.schemas.size());
  s.channels = static_cast<std::uint32_t>(channels.size());
  s.attachments = static_cast<std::uint32_t>(summary.attachments.size());
  s.metadata = static_cast<std::uint32_t>(summary.metadata.size());
  s.chunks = static_cast<std::uint32_t>(summary.chunks.size());
  for (std::uint16_t id = 1; id <= channels.size(); ++id) s.channel_messages[id] = channels[id - 1u].messages;
  summary.statistics = s;
  head.clear();
  head.number(static_cast<std::uint8_t>(Op::data_end));
  head.number(std::uint64_t{4});
  head.number(end.crc());
  encode_end(head, summary, end.size() + head.size());
  data_size = end.size(), data_crc = end.crc();
  if (auto done = end.append(head.bytes()); !done) {
    ++counters.failed_writes;
    return done;
  }
  sync();
  counters.file_bytes = end.size();
  return {};
}

Status Writer::State::finish() {
  if (auto done = append_end(); !done) return done;
  if (auto done = end.file().settle(); !done) {
    ++counters.failed_writes;
    static_cast<void>(end.cut(data_size, data_crc));  // FileEnd knows when that fails
    counters.file_bytes = end.size();
    return done;
  }
  finished = true;
  return {};
}

}  // namespace sinew::record
