#include "record/run/ring_dump.hpp"

#include <algorithm>

#include "record/memory_input.hpp"
#include "record/reader.hpp"
#include "record/run/ring_memory.hpp"
#include "record/run/run_messages.hpp"
#include "record/run/run_review.hpp"
#include "record/writer.hpp"

namespace sinew::record {
namespace {

using hal::Status;

using Readers = std::vector<std::unique_ptr<Reader>>;

Readers open_all(std::span<const std::span<const std::byte>> parts, std::vector<FileProblem>& problems) {
  Readers readers;
  for (const auto& bytes : parts) {
    FileProblem why;
    auto reader = Reader::open(std::make_unique<MemoryInput>(bytes), why);
    if (!reader)
      problems.push_back(why);
    else if (reader->statistics() && reader->statistics()->messages != 0)
      readers.push_back(std::move(reader));
  }
  return readers;
}

class RingDump {
 public:
  RingDump(Readers readers, Writer& to, Dumped& result) : to_(to), result_(result), readers_(std::move(readers)) {}

  Status run(const std::string& reason) {
    if (auto done = begin(reason); !done) return done;
    for (const auto& reader : readers_)
      if (auto done = messages(*reader); !done) return done;
    return {};
  }

 private:
  /// All parts describe the run alike, except for their beginning.
  Status begin(const std::string& reason) {
    Reader& first = *readers_.front();
    for (const std::string_view name : {std::string_view("sinew.run"), std::string_view("sinew.modules"),
                                        std::string_view("sinew.threads"), std::string_view("sinew.chains"),
                                        std::string_view("sinew.graph"), std::string_view("sinew.params"), kBeginName})
      if (Texts texts = read_metadata(first, name); !texts.empty())
        if (auto done = to_.add_metadata({std::string(name), std::move(texts)}); !done) return done;
    if (auto done = to_.add_metadata({"sinew.dump", {{"reason", reason}}}); !done) return done;
    for (const AttachmentIndex& index : first.attachments()) {
      Attachment a;
      FileProblem why;
      if (!first.read(index, a, why))
        result_.problems.push_back(why);
      else if (auto done = to_.attach(a); !done)
        return done;
    }
    return channels();
  }

  /// All parts number their channels alike; an unfinished part may lack channels without messages.
  Status channels() {
    std::map<std::uint16_t, std::pair<Schema, Channel>> all;
    for (const auto& reader : readers_)
      for (const auto& [id, channel] : reader->channels())
        if (const auto schema = reader->schemas().find(channel.schema); schema != reader->schemas().end())
          all.emplace(id, std::pair(schema->second, channel));
    std::map<std::string, std::uint16_t> schemas;
    for (const auto& [id, both] : all) {
      const auto& [schema, channel] = both;
      if (!schemas.contains(schema.name)) {
        auto added = to_.add_schema(schema.name, schema.encoding, schema.data);
        if (!added) return added.error();
        schemas.emplace(schema.name, *added);
      }
      const bool plain = schema.name == image_schema().name;
      auto added = to_.add_channel(channel.topic, channel.message_encoding, schemas.at(schema.name), channel.metadata,
                                   plain ? Packing::plain : Packing::packed);
      if (!added) return added.error();
      channels_[id].id = *added;
      channels_[id].repeats = !channel.topic.starts_with("sinew/");
    }
    return {};
  }

  Status messages(Reader& from) {
    auto messages = from.messages({.order = Order::file});
    Message m;
    for (Next next; (next = messages.next(m)) != Next::end;) {
      if (next == Next::problem) {
        result_.problems.push_back(messages.problem());
        continue;
      }
      const auto known = channels_.find(m.channel->id);
      if (known == channels_.end()) continue;
      Out& out = known->second;
      // Messages latched when the part began are in the parts before it.
      const auto ahead = static_cast<std::int32_t>(m.stamps.sequence - out.before.value_or(0));
      if (out.repeats && out.before && ahead <= 0) continue;
      if (auto done = to_.write(out.id, m.stamps, m.data); !done) return done;
      ++result_.messages;
      out.newest = m.stamps.sequence;
    }
    for (auto& [id, out] : channels_) out.before = out.newest;
    return {};
  }

  struct Out {
    std::uint16_t id = 0;
    bool repeats = false;
    std::optional<std::uint32_t> newest{}, before{};  // sequence; of the parts before this one
  };
  Writer& to_;
  Dumped& result_;
  Readers readers_;
  std::map<std::uint16_t, Out> channels_;
};

/// Writes the verdict, from the content of the file.
Status judge(Writer& writer, const DumpFile& file, Dumped& result) {
  if (auto done = writer.flush(); !done) return done;
  auto written = file.written();
  if (!written) return written.error();
  FileProblem why;
  auto reader = Reader::open(std::move(*written), why);
  if (!reader) return hal::Error{hal::Errc::bad_data, "flight ring: its dump cannot be read"};
  const RunReview found = review(*reader);
  result.verdict = found.verdict;
  Texts verdicts, from, losses;
  for (const ModuleVerdict& v : found.verdict) {
    verdicts.emplace(v.module, to_text(v));
    if (v.from) from.emplace(v.module, std::to_string(v.from->ns));
  }
  for (const auto& [topic, lost] : found.lost_messages) losses.emplace(topic, to_text(lost, "messages"));
  for (const auto& [thread, lost] : found.lost_steps) losses.emplace("thread " + thread, to_text(lost, "steps"));
  if (auto done = writer.add_metadata({std::string(kFromName), std::move(from)}); !done) return done;
  if (auto done = writer.add_metadata({"sinew.verdict", std::move(verdicts)}); !done) return done;
  return writer.add_metadata({"sinew.losses", std::move(losses)});
}

}  // namespace

Status dump_ring(std::span<const std::span<const std::byte>> parts, const DumpFile& to, const std::string& reason,
                 std::uint64_t free_floor_bytes, Dumped& result) {
  Readers readers = open_all(parts, result.problems);
  if (readers.empty()) return hal::Error{hal::Errc::not_found, "flight ring: nothing is in it yet"};
  auto file = to.open();
  if (!file) return file.error();
  auto writer = Writer::open(std::move(*file), {.chunk_bytes = 256 * 1024, .free_floor_bytes = free_floor_bytes});
  if (!writer) return writer.error();
  Status dumped = RingDump(std::move(readers), **writer, result).run(reason);
  if (dumped) dumped = judge(**writer, to, result);
  const Status finished = (*writer)->finish();  // with a full disk, too, the file becomes whole with what it took
  result.bytes = (*writer)->counters().file_bytes;
  return dumped ? finished : dumped;
}

}  // namespace sinew::record
