#include "record/copy.hpp"

#include <algorithm>
#include <set>
#include <tuple>

namespace sinew::record {
namespace {

using hal::Status;

/// Two channels, or schemas, of different files are the same if their keys are equal.
using SchemaKey = std::tuple<std::string, std::string, std::string>;
using ChannelKey = std::tuple<std::string, std::string, Texts, SchemaKey>;

SchemaKey key_of(const Reader& reader, std::uint16_t schema) {
  const auto at = reader.schemas().find(schema);
  return at == reader.schemas().end() ? SchemaKey() : SchemaKey(at->second.name, at->second.encoding, at->second.data);
}

class Copy {
 public:
  Copy(std::span<Reader* const> from, const Query& what, Writer& to, Copied& result, Conversion* conversion)
      : what_(what), to_(to), result_(result), conversion_(conversion) {
    for (Reader* reader : from) sources_.push_back({*reader});
  }

  Status run() {
    for (Source& source : sources_) {
      for (const FileProblem& p : source.reader.problems()) note(p);
      find_plain(source.reader);
      if (auto done = definitions(source); !done) return done;
    }
    for (Source& source : sources_) {
      if (auto done = metadata(source.reader); !done) return done;
      if (auto done = attachments(source.reader); !done) return done;
    }
    return messages();
  }

 private:
  struct Source {
    Reader& reader;
    std::map<std::uint16_t, std::uint16_t> schemas{}, channels{};  // new numbers of the old ones
    std::map<std::uint16_t, const Schema*> converted{};            // by channel: the schema it is converted to
    std::optional<MessageReader> messages{};
    Message message{};
  };

  bool wanted(const Channel& channel) const {
    return what_.topics.empty() ||
           std::find(what_.topics.begin(), what_.topics.end(), channel.topic) != what_.topics.end();
  }

  /// Topics that were in a chunk without compression.
  void find_plain(const Reader& reader) {
    for (const ChunkIndex& chunk : reader.chunks())
      if (chunk.compression.empty())
        for (const auto& [id, place] : chunk.message_indexes)
          if (const auto channel = reader.channels().find(id); channel != reader.channels().end())
            plain_.insert(channel->second.topic);
  }

  Status definitions(Source& source) {
    for (const auto& [id, channel] : source.reader.channels())
      if (wanted(channel))
        if (auto done = add_channel(source, channel); !done) return done;
    if (!what_.topics.empty() || conversion_) return {};
    for (const auto& [id, schema] : source.reader.schemas())  // unused schemas, too
      if (auto done = add_schema(source, id); !done) return done;
    return {};
  }

  /// The number that another file has given to the same thing, unless `mine` uses that number already.
  template <class Key>
  static std::uint16_t shared(const std::multimap<Key, std::uint16_t>& known, const Key& key,
                              const std::map<std::uint16_t, std::uint16_t>& mine) {
    const auto same = known.equal_range(key);
    for (auto at = same.first; at != same.second; ++at)
      if (std::none_of(mine.begin(), mine.end(), [&](const auto& m) { return m.second == at->second; }))
        return at->second;
    return 0;
  }

  Status add_schema(Source& source, std::uint16_t id) {
    if (id == 0 || source.schemas.contains(id)) return {};
    const SchemaKey key = key_of(source.reader, id);
    std::uint16_t number = shared(schemas_, key, source.schemas);
    if (number == 0) {
      auto added = to_.add_schema(std::get<0>(key), std::get<1>(key), std::get<2>(key));
      if (!added) return added.error();
      schemas_.emplace(key, number = *added);
    }
    source.schemas[id] = number;
    return {};
  }

  /// A channel whose messages are converted.
  Status add_converted(Source& source, const Channel& channel, const Schema& from, const Schema& to) {
    auto schema = to_.add_schema(to.name, to.encoding, to.data);
    if (!schema) return schema.error();
    auto added = to_.add_channel(channel.topic, channel.message_encoding, *schema, channel.metadata);
    if (!added) return added.error();
    source.channels[channel.id] = *added;
    source.converted[channel.id] = &from;
    return {};
  }

  Status add_channel(Source& source, const Channel& channel) {
    if (const auto from = source.reader.schemas().find(channel.schema);
        conversion_ && from != source.reader.schemas().end())
      if (const auto to = conversion_->schema(channel, from->second))
        return add_converted(source, channel, from->second, *to);
    if (auto done = add_schema(source, channel.schema); !done) return done;
    const ChannelKey key(channel.topic, channel.message_encoding, channel.metadata,
                         key_of(source.reader, channel.schema));
    std::uint16_t number = shared(channels_, key, source.channels);
    if (number == 0) {
      auto added = to_.add_channel(channel.topic, channel.message_encoding, source.schemas[channel.schema],
                                   channel.metadata, plain_.contains(channel.topic) ? Packing::plain : Packing::packed);
      if (!added) return added.error();
      channels_.emplace(key, number = *added);
    }
    source.channels[channel.id] = number;
    return {};
  }

  Status metadata(Reader& from) {
    for (const MetadataIndex& index : from.metadata()) {
      Metadata m;
      if (!readable(from, index, m) || !metadata_.emplace(m.name, m.values).second) continue;
      if (auto done = to_.add_metadata(m); !done) return done;
      ++result_.metadata;
    }
    return {};
  }

  Status attachments(Reader& from) {
    for (const AttachmentIndex& index : from.attachments()) {
      Attachment a;
      if (!readable(from, index, a) ||
          !attachments_.emplace(a.log_time, a.create_time, a.name, a.media_type, a.data).second)
        continue;
      if (auto done = to_.attach(a); !done) return done;
      ++result_.attachments;
    }
    return {};
  }

  template <class Index, class Value>
  bool readable(Reader& from, const Index& index, Value& value) {
    FileProblem why;
    if (from.read(index, value, why)) return true;
    note(why);
    return false;
  }

  /// False: the source has no more.
  bool advance(Source& source) {
    while (true) {
      const Next next = source.messages->next(source.message);
      if (next != Next::problem) return next == Next::message;
      note(source.messages->problem());
    }
  }

  Status messages() {
    Query query = what_;
    query.order = sources_.size() == 1 ? Order::file : Order::log_time;
    std::vector<Source*> open;
    for (Source& source : sources_) {
      source.messages.emplace(source.reader, query);
      if (advance(source)) open.push_back(&source);
    }
    while (!open.empty()) {
      const auto first = std::min_element(open.begin(), open.end(), [](const Source* a, const Source* b) {
        return a->message.stamps.log_time < b->message.stamps.log_time;
      });
      Source& source = **first;
      const Message& m = source.message;
      if (!source.channels.contains(m.channel->id))  // the summary need not have it
        if (auto done = add_channel(source, *m.channel); !done) return done;
      if (auto done = write(source, m); !done) return done;
      if (!advance(source)) open.erase(first);
    }
    return {};
  }

  Status write(Source& source, const Message& m) {
    auto data = m.data;
    if (const auto from = source.converted.find(m.channel->id); from != source.converted.end()) {
      data = conversion_->convert(m, *from->second);
      if (data.empty()) {
        note({ProblemKind::bad_record, 0, "a message of " + m.channel->topic + " does not fit its schema"});
        return {};
      }
    }
    ++result_.messages;
    return to_.write(source.channels[m.channel->id], m.stamps, data);
  }

  /// Reading the messages reports the problems of opening again.
  void note(const FileProblem& problem) {
    const bool known = std::any_of(result_.problems.begin(), result_.problems.end(), [&](const FileProblem& p) {
      return p.offset == problem.offset && p.kind == problem.kind && p.text == problem.text;
    });
    if (!known) result_.problems.push_back(problem);
  }

  const Query& what_;
  Writer& to_;
  Copied& result_;
  Conversion* const conversion_;
  std::vector<Source> sources_;
  std::set<std::string> plain_;
  std::multimap<SchemaKey, std::uint16_t> schemas_;
  std::multimap<ChannelKey, std::uint16_t> channels_;
  std::set<std::pair<std::string, Texts>> metadata_;
  std::set<std::tuple<std::uint64_t, std::uint64_t, std::string, std::string, std::string>> attachments_;
};

}  // namespace

WriterOptions options_like(const Reader& from) {
  WriterOptions options;
  options.profile = from.header().profile, options.library = from.header().library;
  for (const ChunkIndex& chunk : from.chunks())
    if (chunk.compression == to_string(Compression::zstd)) options.compression = Compression::zstd;
  return options;
}

std::optional<std::string> topic_conflict(std::span<Reader* const> from) {
  std::map<std::string, SchemaKey> known;
  for (const Reader* reader : from)
    for (const auto& [id, channel] : reader->channels()) {
      const SchemaKey key = key_of(*reader, channel.schema);
      const auto [at, is_new] = known.emplace(channel.topic, key);
      if (is_new || at->second == key) continue;
      const std::string &here = std::get<0>(key), &there = std::get<0>(at->second);
      return "topic " + channel.topic + ": " +
             (here == there ? here + " with different fields" : there + " and " + here);
    }
  return std::nullopt;
}

Status copy(std::span<Reader* const> from, const Query& what, Writer& to, Copied& result, Conversion* conversion) {
  return Copy(from, what, to, result, conversion).run();
}

}  // namespace sinew::record
