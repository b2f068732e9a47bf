#pragma once
#include <optional>
#include <string>
#include <vector>

#include "record/reader.hpp"
#include "record/writer.hpp"

namespace sinew::record {

struct Copied {
  std::uint64_t messages = 0, attachments = 0, metadata = 0;
  std::vector<FileProblem> problems;  // what could not be kept, and why
};

/// Converts the messages of some channels during a copy().
/// Thread:  owner.
class Conversion {
 public:
  virtual ~Conversion() = default;
  /// The schema after the conversion; nothing: messages of this channel stay as they are.
  virtual std::optional<Schema> schema(const Channel& channel, const Schema& from) = 0;
  /// Converts a message of such a channel; empty: the message does not fit its schema. Owner: good until the next call.
  virtual std::span<const std::byte> convert(const Message& message, const Schema& from) = 0;
};

/// Changes that copy() makes besides the query.
struct CopyChanges {
  std::vector<Metadata> metadata{};           // replaces that of the same name; without values: none
  std::vector<std::string> earlier_topics{};  // copied from the beginning on, not from Query::from on
};

/// Options for a writer of the content of `from`: its profile and library, zstd where it has that.
WriterOptions options_like(const Reader& from);

/// Names a topic that two of these files have with different schemas; nothing: they can be merged.
std::optional<std::string> topic_conflict(std::span<Reader* const> from);

/// Copies all that a query asks for and that can be read: messages with their channels and schemas, every attachment,
/// all metadata; things that several files share, once, messages included. Messages of one file keep its order; those
/// of several are in the order of log time. The caller finishes `to`. Errors:  those of the writer.
hal::Status copy(std::span<Reader* const> from, const Query& what, Writer& to, Copied& result,
                 Conversion* conversion = nullptr, const CopyChanges& changes = {});

}  // namespace sinew::record
