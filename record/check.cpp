#include "record/check.hpp"

#include <algorithm>

#include "record/crc32.hpp"
#include "record/file_ending.hpp"
#include "record/scan.hpp"

namespace sinew::record {
namespace {

class Checker {
 public:
  Checker(hal::InputFile& file, const ReadLimits& limits) : file_(file), limits_(limits), found_(scan(file, limits)) {}

  std::vector<FileProblem> run() {
    problems_ = found_.problems;
    if (!found_.whole) return std::move(problems_);  // the rest is not there
    check_data_crc();
    FileProblem why;
    const SummaryState state = read_ending(file_, limits_, ending_, why);
    at_ = ending_.footer.summary_start;
    if (state == SummaryState::damaged || (state == SummaryState::none && why.offset == file_.size()))
      problems_.push_back(why);
    if (state == SummaryState::whole) check_summary();
    return std::move(problems_);
  }

 private:
  void report(std::uint64_t offset, std::string text) {
    problems_.push_back({ProblemKind::bad_index, offset, std::move(text)});
  }

  void check_data_crc() {
    if (found_.data_crc == 0) return;
    constexpr std::uint64_t kPiece = 1 << 20;
    Buffer bytes;
    FileProblem why;
    std::uint32_t crc = 0;
    for (std::uint64_t at = 0; at < found_.data_end; at += kPiece) {
      if (!read_bytes(file_, at, std::min(kPiece, found_.data_end - at), limits_, bytes, why)) {
        problems_.push_back(why);
        return;
      }
      crc = crc32(bytes.bytes(), crc);
    }
    if (crc != found_.data_crc)
      problems_.push_back({ProblemKind::bad_checksum, found_.data_end,
                           "the bytes of the data section are not those that were written"});
  }

  void check_summary() {
    const Summary& said = ending_.summary;
    if (!said.chunks.empty()) check_chunks();
    compare(said.attachments, found_.summary.attachments, "the attachment indexes are not those of the attachments");
    compare(said.metadata, found_.summary.metadata, "the metadata indexes are not those of the metadata");
    for (const auto& [id, schema] : said.schemas)
      if (auto it = found_.summary.schemas.find(id); it != found_.summary.schemas.end() && it->second != schema)
        report(at_, "schema " + std::to_string(id) + " of the summary is not that of the data");
    for (const auto& [id, channel] : said.channels)
      if (auto it = found_.summary.channels.find(id); it != found_.summary.channels.end() && it->second != channel)
        report(at_, "channel " + std::to_string(id) + " of the summary is not that of the data");
    if (said.statistics) check_statistics(*said.statistics);
    for (const SummaryOffset& offset : ending_.offsets)
      if (std::none_of(ending_.groups.begin(), ending_.groups.end(), [&](const SummaryOffset& group) {
            return group.group == offset.group && group.start == offset.start && group.length == offset.length;
          }))
        report(offset.start, "no group of records of the summary is where a summary offset says");
  }

  template <class Records>
  void compare(const Records& said, const Records& found, const char* text) {
    if (said != found) report(at_, text);
  }

  void check_chunks() {
    std::map<std::uint64_t, const ChunkIndex*> said;
    for (const ChunkIndex& chunk : ending_.summary.chunks) said.emplace(chunk.offset, &chunk);
    for (const ChunkIndex& chunk : found_.summary.chunks) {
      const auto it = said.find(chunk.offset);
      if (it == said.end()) {
        report(chunk.offset, "the chunk here is not in the summary");
      } else if (const ChunkIndex& index = *it->second;
                 index.length != chunk.length || index.start_time != chunk.start_time ||
                 index.end_time != chunk.end_time || index.compression != chunk.compression ||
                 index.compressed_size != chunk.compressed_size || index.uncompressed_size != chunk.uncompressed_size ||
                 index.message_index_length != chunk.message_index_length ||
                 (!index.message_indexes.empty() && index.message_indexes != chunk.message_indexes)) {
        report(chunk.offset, "the chunk here is not as the summary says");
      }
    }
    for (const Block& block : found_.blocks) said.erase(block.offset);
    for (const auto& [offset, chunk] : said) report(offset, "the summary tells of a chunk here");
    if (std::any_of(found_.blocks.begin(), found_.blocks.end(),
                    [](const Block& block) { return block.loose && !block.channels.empty(); }))
      report(at_, "the summary has chunk indexes, but there are messages outside of chunks");
  }

  void check_statistics(Statistics said) {
    Statistics found = *found_.summary.statistics;
    const auto no_zeros = [](auto& counts) { std::erase_if(counts, [](const auto& c) { return c.second == 0; }); };
    if (said.channel_messages.empty()) found.channel_messages.clear();  // not available
    no_zeros(said.channel_messages), no_zeros(found.channel_messages);
    if (said != found)
      report(at_, "the statistics are not those of the data: " + std::to_string(said.messages) + " messages in " +
                      std::to_string(said.chunks) + " chunks, found " + std::to_string(found.messages) + " in " +
                      std::to_string(found.chunks));
  }

  hal::InputFile& file_;
  ReadLimits limits_;
  Scan found_;
  FileEnding ending_;
  std::uint64_t at_ = 0;  // of the summary
  std::vector<FileProblem> problems_;
};

}  // namespace

std::vector<FileProblem> check(hal::InputFile& file, const ReadLimits& limits) { return Checker(file, limits).run(); }

}  // namespace sinew::record
