#include "record/recover.hpp"

#include <algorithm>
#include <set>

#include "record/writer.hpp"

namespace sinew::record {
namespace {

using hal::Status;

class Recovery {
 public:
  Recovery(Reader& from, Writer& to, Recovered& result) : from_(from), to_(to), result_(result) {}

  Status run() {
    result_.problems = from_.problems();
    for (const auto& step :
         {&Recovery::copy_definitions, &Recovery::copy_metadata, &Recovery::copy_attachments, &Recovery::copy_messages})
      if (auto done = (this->*step)(); !done) return done;
    return to_.finish();
  }

 private:
  Status copy_definitions() {
    for (const ChunkIndex& chunk : from_.chunks())
      if (chunk.compression.empty())
        for (const auto& [channel, place] : chunk.message_indexes) plain_.insert(channel);
    for (const auto& [id, channel] : from_.channels())
      if (auto done = copy_channel(channel); !done) return done;
    for (const auto& [id, schema] : from_.schemas())
      if (auto done = copy_schema(id); !done) return done;
    return {};
  }

  Status copy_schema(std::uint16_t id) {
    if (id == 0 || schemas_.contains(id)) return {};
    const Schema& schema = from_.schemas().at(id);
    auto added = to_.add_schema(schema.name, schema.encoding, schema.data);
    if (!added) return added.error();
    schemas_[id] = *added;
    return {};
  }

  Status copy_channel(const Channel& channel) {
    if (auto done = copy_schema(channel.schema); !done) return done;
    auto added = to_.add_channel(channel.topic, channel.message_encoding, schemas_[channel.schema], channel.metadata,
                                 plain_.contains(channel.id) ? Packing::plain : Packing::packed);
    if (!added) return added.error();
    channels_[channel.id] = *added;
    return {};
  }

  Status copy_metadata() {
    for (const MetadataIndex& index : from_.metadata()) {
      Metadata metadata;
      if (!readable(index, metadata)) continue;
      if (auto done = to_.add_metadata(metadata); !done) return done;
      ++result_.metadata;
    }
    return {};
  }

  Status copy_attachments() {
    for (const AttachmentIndex& index : from_.attachments()) {
      Attachment attachment;
      if (!readable(index, attachment)) continue;
      if (auto done = to_.attach(attachment); !done) return done;
      ++result_.attachments;
    }
    return {};
  }

  template <class Index, class Value>
  bool readable(const Index& index, Value& value) {
    Problem why;
    if (from_.read(index, value, why)) return true;
    note(why);
    return false;
  }

  Status copy_messages() {
    MessageReader messages = from_.messages({.topics = {}, .order = Order::file});
    Message message;
    for (;;) {
      switch (messages.next(message)) {
        case Next::end:
          return {};
        case Next::problem:
          note(messages.problem());
          break;
        case Next::message:
          if (!channels_.contains(message.channel->id))  // the summary need not have it
            if (auto done = copy_channel(*message.channel); !done) return done;
          if (auto done = to_.write(channels_[message.channel->id], message.stamps, message.data); !done) return done;
          ++result_.messages;
      }
    }
  }

  /// What was found on opening is told again by the messages.
  void note(const Problem& problem) {
    const bool known = std::any_of(result_.problems.begin(), result_.problems.end(), [&](const Problem& p) {
      return p.offset == problem.offset && p.kind == problem.kind;
    });
    if (!known) result_.problems.push_back(problem);
  }

  Reader& from_;
  Writer& to_;
  Recovered& result_;
  std::set<std::uint16_t> plain_;                              // channels that were in a chunk without compression
  std::map<std::uint16_t, std::uint16_t> schemas_, channels_;  // new numbers of the old ones; 0 stays 0
};

}  // namespace

Status recover(std::unique_ptr<hal::InputFile> from, std::unique_ptr<hal::OutputFile> to, Recovered& result,
               const ReadLimits& limits) {
  Problem why;
  auto reader = Reader::open(std::move(from), why, limits);
  if (!reader) {
    result.problems.push_back(why);
    return hal::Error{hal::Errc::bad_data, "not an MCAP file"};
  }
  WriterOptions options;
  options.profile = reader->header().profile, options.library = reader->header().library;
  for (const ChunkIndex& chunk : reader->chunks())
    if (chunk.compression == to_string(Compression::zstd)) options.compression = Compression::zstd;
  auto writer = Writer::open(std::move(to), options);
  if (!writer) return writer.error();
  return Recovery(*reader, **writer, result).run();
}

}  // namespace sinew::record
