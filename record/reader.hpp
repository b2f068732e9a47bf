#pragma once
#include <memory>
#include <string>
#include <vector>

#include "record/chunk_contents.hpp"

namespace sinew::record {

/// One message in a file.
/// Owner:   views stay valid until the next call of next() or seek().
struct Message {
  const Channel* channel = nullptr;
  Stamps stamps;
  std::span<const std::byte> data;
};

enum class Order : std::uint8_t {
  log_time,  // at equal times in the order of the file
  file,      // in the order of the file
};

struct Query {
  std::vector<std::string> topics{};                  // none: all
  std::uint64_t from = 0, until = ~std::uint64_t{0};  // log time, both included
  Order order = Order::log_time;
};

class MessageReader;

/// Reads any MCAP file: by its summary if that is whole, otherwise by scanning the whole file. Every checksum in the
/// file is checked before a byte under it is handed out; only the header and the metadata have no checksum of their own
/// (check.hpp checks the one over the whole file).
///
/// Thread:  owner.
/// Errors:  as FileProblem: kind, place in the file, what would be right.
class Reader {
 public:
  /// Null when it is no MCAP file at all; other errors are among the problems of the file.
  static std::unique_ptr<Reader> open(std::unique_ptr<hal::InputFile> file, FileProblem& why,
                                      const ReadLimits& limits = {});
  ~Reader();

  bool by_summary() const { return by_summary_; }  // false: the whole file was scanned
  /// The problems found on opening; empty for a whole file. next() reports again the chunks that cannot be read.
  const std::vector<FileProblem>& problems() const { return problems_; }
  const Header& header() const { return header_; }
  const std::map<std::uint16_t, Schema>& schemas() const { return summary_.schemas; }
  const std::map<std::uint16_t, Channel>& channels() const { return summary_.channels; }
  const std::vector<ChunkIndex>& chunks() const { return summary_.chunks; }
  /// Where the messages are, in the order of the file: its chunks, and records outside of them.
  const std::vector<Block>& blocks() const { return blocks_; }
  const std::vector<AttachmentIndex>& attachments() const { return summary_.attachments; }
  const std::vector<MetadataIndex>& metadata() const { return summary_.metadata; }
  /// The file's own statistics or, after a scan, those of the readable part.
  const std::optional<Statistics>& statistics() const { return summary_.statistics; }

  bool read(const AttachmentIndex& index, Attachment& attachment, FileProblem& why);
  bool read(const MetadataIndex& index, Metadata& metadata, FileProblem& why);
  MessageReader messages(const Query& query = {});

 private:
  friend class MessageReader;
  Reader(std::unique_ptr<hal::InputFile> file, const ReadLimits& limits) : file_(std::move(file)), limits_(limits) {}
  bool summary_is_usable(std::uint64_t summary_start, FileProblem& why);
  void read_header();
  void use_scan(FileProblem why);

  std::unique_ptr<hal::InputFile> file_;
  ReadLimits limits_;
  bool by_summary_ = false;
  std::vector<FileProblem> problems_;
  std::optional<FileProblem> cut_;  // why the data end early
  Header header_;
  Summary summary_;
  std::vector<Block> blocks_;
};

enum class Next : std::uint8_t {
  message,
  problem,  // messages are missing here; reading goes on behind them
  end,
};

/// Goes through the messages that a query asks for. Chunks without such messages are not read; in the order of log
/// time, chunks that overlap are in memory together.
/// Owner:   the Reader must outlive it.
class MessageReader {
 public:
  MessageReader(Reader& reader, Query query);
  ~MessageReader();
  MessageReader(MessageReader&&) noexcept;
  Next next(Message& message);
  const FileProblem& problem() const;  // after Next::problem
  /// Goes on with the first message at or after this log time; also backwards.
  void seek(std::uint64_t log_time);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The metadata of that name; empty when there is none or it cannot be read.
Texts read_metadata(Reader& reader, std::string_view name);
/// The data of the attachment of that name; nothing when there is none or it cannot be read.
std::optional<std::string> read_attachment(Reader& reader, std::string_view name);

}  // namespace sinew::record
