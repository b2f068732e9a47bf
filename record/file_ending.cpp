#include "record/file_ending.hpp"

#include <algorithm>

#include "record/crc32.hpp"

namespace sinew::record {
namespace {

/// The file's last bytes. False: an MCAP file does not end like this.
bool read_footer(hal::InputFile& file, const ReadLimits& limits, Footer& footer, FileProblem& why) {
  why = {ProblemKind::truncated, file.size(), "no footer and magic at the end of the file"};
  if (file.size() < kMagic.size() + kFileTail) return false;
  Buffer bytes;
  if (!read_bytes(file, file.size() - kFileTail, kFileTail, limits, bytes, why)) return false;
  auto rest = bytes.bytes();
  Op op{};
  std::span<const std::byte> content;
  return take_record(rest, op, content) && op == Op::footer && decode(content, footer) &&
         std::equal(rest.begin(), rest.end(), kMagic.begin(), kMagic.end());
}

bool parse(std::span<const std::byte> bytes, std::uint64_t at, FileEnding& ending, FileProblem& why) {
  auto rest = bytes;
  std::vector<Schema> schemas;
  std::vector<Channel> channels;
  while (!rest.empty()) {
    const std::uint64_t place = at + (bytes.size() - rest.size());
    Op op{};
    std::span<const std::byte> content;
    bool good = take_record(rest, op, content);
    Summary& s = ending.summary;
    switch (good ? op : Op{}) {
      case Op::schema:
        good = decode(content, schemas.emplace_back());
        break;
      case Op::channel:
        good = decode(content, channels.emplace_back());
        break;
      case Op::chunk_index:
        good = decode(content, s.chunks.emplace_back());
        break;
      case Op::attachment_index:
        good = decode(content, s.attachments.emplace_back());
        break;
      case Op::metadata_index:
        good = decode(content, s.metadata.emplace_back());
        break;
      case Op::statistics:
        good = decode(content, s.statistics.emplace());
        break;
      case Op::summary_offset:
        good = decode(content, ending.offsets.emplace_back());
        break;
      default:
        break;  // unknown records are skipped
    }
    if (!good) {
      why = {ProblemKind::bad_record, place, "a record of the summary is shorter than its fields"};
      return false;
    }
    if (op == Op::summary_offset) continue;
    if (ending.groups.empty() || ending.groups.back().group != op) ending.groups.push_back({op, place, 0});
    ending.groups.back().length += kRecordHead + content.size();
  }
  return merge_definitions(schemas, channels, at, ending.summary, why);
}

}  // namespace

SummaryState read_ending(hal::InputFile& file, const ReadLimits& limits, FileEnding& ending, FileProblem& why) {
  Footer& footer = ending.footer;
  if (!read_footer(file, limits, footer, why)) return SummaryState::none;
  const std::uint64_t footer_at = file.size() - kFileTail;
  if (footer.summary_start == 0) {
    why = {ProblemKind::truncated, footer_at, "the file has no summary"};
    return SummaryState::none;
  }
  if (footer.summary_start < kMagic.size() || footer.summary_start > footer_at) {
    why = {ProblemKind::bad_index, footer_at,
           "the summary is said to start at " + std::to_string(footer.summary_start) + "; the data start at " +
               std::to_string(kMagic.size()) + ", the footer at " + std::to_string(footer_at)};
    return SummaryState::damaged;
  }
  Buffer bytes;
  if (!read_bytes(file, footer.summary_start, file.size() - footer.summary_start, limits, bytes, why))
    return SummaryState::damaged;
  const std::size_t checked = bytes.size() - kMagic.size() - 4;
  if (footer.summary_crc != 0 && crc32(bytes.bytes().first(checked)) != footer.summary_crc) {
    why = {ProblemKind::bad_checksum, footer.summary_start, "the summary's bytes are not those that were written"};
    return SummaryState::damaged;
  }
  return parse(bytes.bytes().first(bytes.size() - kFileTail), footer.summary_start, ending, why)
             ? SummaryState::whole
             : SummaryState::damaged;
}

}  // namespace sinew::record
