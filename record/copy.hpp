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

/// What copy() makes of messages of some kinds.
/// Thread:  owner.
class Conversion {
 public:
  virtual ~Conversion() = default;
  /// What the messages of this channel become; nothing: they stay as they are.
  virtual std::optional<Schema> schema(const Channel& channel, const Schema& from) = 0;
  /// A message of such a channel; empty: it is no message of its schema. Owner: good until the next call.
  virtual std::span<const std::byte> convert(const Message& message, const Schema& from) = 0;
};

/// What copy() does otherwise than the query says.
struct CopyChanges {
  std::vector<Metadata> metadata{};           // in the place of that of the same name; without values: none
  std::vector<std::string> earlier_topics{};  // from the beginning on, not from Query::from on
};

/// Options for a writer of what `from` holds: its profile and library, zstd where it has that.
WriterOptions options_like(const Reader& from);

/// A topic that two of these files have with different schemas, in words; nothing: they can be merged.
std::optional<std::string> topic_conflict(std::span<Reader* const> from);

/// Copies what a query asks for and can be read: messages with their channels and schemas, every attachment, all
/// metadata; what several files have alike, once, messages included. Messages of one file keep its order, those of
/// several are in the order of log time. The caller finishes `to`. Errors:  those of the writer.
hal::Status copy(std::span<Reader* const> from, const Query& what, Writer& to, Copied& result,
                 Conversion* conversion = nullptr, const CopyChanges& changes = {});

}  // namespace sinew::record
