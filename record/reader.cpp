#include "record/reader.hpp"

#include <algorithm>

#include "record/file_ending.hpp"
#include "record/scan.hpp"

namespace sinew::record {
namespace {

std::string number(std::uint64_t value) { return std::to_string(value); }

bool starts_with_magic(hal::InputFile& file) {
  std::array<std::byte, kMagic.size()> magic{};
  return file.size() >= magic.size() && file.read_at(0, magic) && magic == kMagic;
}

/// Sorts records by their place. False: some lie outside of the data or overlap. Overlaps are refused because a small
/// file could ask for the same large record again and again.
template <class Index>
bool apart(std::vector<Index>& records, std::uint64_t data_end) {
  std::sort(records.begin(), records.end(), [](const Index& a, const Index& b) { return a.offset < b.offset; });
  std::uint64_t at = kMagic.size();
  for (const Index& record : records) {
    if (record.offset < at || record.offset > data_end || record.length < kRecordHead ||
        record.length > data_end - record.offset)
      return false;
    at = record.offset + record.length;
  }
  return true;
}

}  // namespace

Reader::~Reader() = default;

std::unique_ptr<Reader> Reader::open(std::unique_ptr<hal::InputFile> file, FileProblem& why, const ReadLimits& limits) {
  std::unique_ptr<Reader> reader(new Reader(std::move(file), limits));
  const bool good_start = starts_with_magic(*reader->file_);
  FileProblem no_summary;
  FileEnding ending;
  reader->by_summary_ = read_ending(*reader->file_, limits, ending, no_summary) == SummaryState::whole;
  if (reader->by_summary_) {
    reader->summary_ = std::move(ending.summary);
    reader->by_summary_ = reader->summary_is_usable(ending.footer.summary_start, no_summary);
  }
  if (!good_start) {
    why = {ProblemKind::not_mcap, 0, "it does not begin with \\x89MCAP0\\r\\n"};
    if (!reader->by_summary_ || ending.footer.summary_crc == 0) return nullptr;
    reader->problems_.push_back(why);  // a damaged first byte: the end of the file proves enough
  }
  if (reader->by_summary_)
    reader->read_header();
  else
    reader->use_scan(std::move(no_summary));
  return reader;
}

void Reader::read_header() {
  Buffer bytes;
  FileProblem problem;
  std::span<const std::byte> content;
  Op op{};
  // The header's own length is not trusted before there are that many bytes.
  const std::uint64_t most = std::min<std::uint64_t>(file_->size() - kMagic.size(), 64 << 10);
  if (read_bytes(*file_, kMagic.size(), most, limits_, bytes, problem)) {
    auto rest = bytes.bytes();
    if (take_record(rest, op, content) && op == Op::header && decode(content, header_)) return;
    problem = {ProblemKind::bad_record, kMagic.size(), "the first record is no Header of at most 64 KiB"};
  }
  problems_.push_back(problem);
}

void Reader::use_scan(FileProblem why) {
  summary_ = {}, blocks_.clear();
  Scan found = scan(*file_, limits_);
  if (!found.whole) cut_ = found.problems.back();
  if (found.whole && why.kind != ProblemKind::truncated) problems_.push_back(std::move(why));
  problems_.insert(problems_.end(), found.problems.begin(), found.problems.end());
  header_ = std::move(found.header);
  summary_ = std::move(found.summary);
  blocks_ = std::move(found.blocks);
}

bool Reader::summary_is_usable(std::uint64_t summary_start, FileProblem& why) {
  why = {ProblemKind::bad_index, summary_start, {}};
  Summary& s = summary_;
  if (s.chunks.empty() && !(s.statistics && s.statistics->messages == 0)) {
    why = {ProblemKind::truncated, summary_start, "the summary has no chunk indexes"};
    return false;
  }
  const bool placed =
      apart(s.chunks, summary_start) && apart(s.attachments, summary_start) && apart(s.metadata, summary_start);
  if (!placed) {
    why.text =
        "chunks, attachments or metadata overlap or lie outside of the data, which end at " + number(summary_start);
    return false;
  }
  for (const ChunkIndex& chunk : s.chunks) {
    if (chunk.start_time > chunk.end_time) {
      why.text = "the chunk at " + number(chunk.offset) + " starts at " + number(chunk.start_time) + " and ends at " +
                 number(chunk.end_time);
      return false;
    }
    Block block{.offset = chunk.offset,
                .length = chunk.length,
                .start_time = chunk.start_time,
                .end_time = chunk.end_time,
                .channels = {},
                .judged = true};
    for (const auto& [channel, place] : chunk.message_indexes) {
      if (!s.channels.contains(channel)) {
        why.text = "channel " + number(channel) + " has messages and is not in the summary";
        return false;
      }
      block.channels.push_back(channel);
    }
    blocks_.push_back(std::move(block));
  }
  return true;
}

bool Reader::read(const AttachmentIndex& index, Attachment& attachment, FileProblem& why) {
  Buffer bytes;
  if (!read_bytes(*file_, index.offset, index.length, limits_, bytes, why)) return false;
  auto rest = bytes.bytes();
  Op op{};
  std::span<const std::byte> content;
  std::uint32_t crc = 0, computed = 0;
  if (!take_record(rest, op, content) || op != Op::attachment || !decode(content, attachment, crc, computed)) {
    why = {ProblemKind::bad_index, index.offset, "no attachment of " + number(index.length) + " bytes is here"};
    return false;
  }
  if (crc != 0 && crc != computed) {
    why = {ProblemKind::bad_checksum, index.offset, "the attachment's bytes are not those that were written"};
    return false;
  }
  return true;
}

bool Reader::read(const MetadataIndex& index, Metadata& metadata, FileProblem& why) {
  Buffer bytes;
  if (!read_bytes(*file_, index.offset, index.length, limits_, bytes, why)) return false;
  auto rest = bytes.bytes();
  Op op{};
  std::span<const std::byte> content;
  if (take_record(rest, op, content) && op == Op::metadata && decode(content, metadata)) return true;
  why = {ProblemKind::bad_index, index.offset, "no metadata of " + number(index.length) + " bytes are here"};
  return false;
}

MessageReader Reader::messages(const Query& query) { return MessageReader(*this, query); }

Texts read_metadata(Reader& reader, std::string_view name) {
  FileProblem why;
  Metadata m;
  for (const MetadataIndex& index : reader.metadata())
    if (index.name == name && reader.read(index, m, why)) return m.values;
  return {};
}

std::optional<std::string> read_attachment(Reader& reader, std::string_view name) {
  FileProblem why;
  Attachment a;
  for (const AttachmentIndex& index : reader.attachments())
    if (index.name == name && reader.read(index, a, why)) return a.data;
  return std::nullopt;
}

}  // namespace sinew::record
