#include "record/scan.hpp"

#include <algorithm>

#include "record/crc32.hpp"
#include "record/record_walk.hpp"

namespace sinew::record {
namespace {

constexpr std::uint64_t kLooseBlock = 1 << 20;  // records outside of chunks are read in runs of about so many bytes

class Scanner {
 public:
  Scanner(hal::InputFile& file, const ReadLimits& limits) : file_(file), limits_(limits) {}

  Scan run() {
    if (!magic_is_good()) return std::move(scan_);
    RecordWalk walk(file_, kMagic.size(), file_.size());
    RecordWalk::Place place;
    FileProblem problem;
    for (bool first = true; !scan_.whole; first = false) {
      const auto next = walk.next(place, problem);
      if (next != RecordWalk::Next::record) {
        end_loose();
        if (next == RecordWalk::Next::end) problem = {ProblemKind::truncated, walk.at(), "the file has no DataEnd"};
        scan_.problems.push_back(problem);
        scan_.data_end = walk.at();
        break;
      }
      if (first != (place.op == Op::header))
        report(ProblemKind::bad_record, place.offset, "the first record, and no other, is a Header");
      take(place);
    }
    finish();
    return std::move(scan_);
  }

 private:
  void report(ProblemKind kind, std::uint64_t offset, std::string text) {
    scan_.problems.push_back({kind, offset, std::move(text)});
  }

  bool magic_is_good() {
    FileProblem problem;
    if (read_bytes(file_, 0, kMagic.size(), limits_, bytes_, problem) &&
        std::equal(kMagic.begin(), kMagic.end(), bytes_.data()))
      return true;
    if (problem.text.empty()) problem = {ProblemKind::not_mcap, 0, "it does not begin with \\x89MCAP0\\r\\n"};
    scan_.problems.push_back(problem);
    return false;
  }

  void take(const RecordWalk::Place& place) {
    const bool loose = place.op == Op::message || place.op == Op::schema || place.op == Op::channel;
    if (!loose || loose_.length >= kLooseBlock) end_loose();
    if (place.op != Op::message_index) {
      end_indexes();
    } else if (last_ != Op::message_index && last_ != Op::chunk) {
      report(ProblemKind::bad_index, place.offset, "a message index stands without a chunk before it");
    }
    last_ = place.op;
    switch (place.op) {
      case Op::message:
        if (chunked_) {  // it has no checksum, and one wrong bit makes a message of a message index
          report(ProblemKind::bad_record, place.offset, "a message outside of chunks, in a file of chunks");
          break;
        }
        [[fallthrough]];
      case Op::schema:
      case Op::channel:
        if (loose_.length == 0) loose_ = Block{.offset = place.offset, .length = 0, .channels = {}, .loose = true};
        loose_.length += place.length;
        break;
      case Op::header:
        take_header(place);
        break;
      case Op::chunk:
        take_chunk(place);
        break;
      case Op::message_index:
        take_message_index(place);
        break;
      case Op::attachment:
        take_attachment(place);
        break;
      case Op::metadata:
        take_metadata(place);
        break;
      case Op::data_end:
        take_data_end(place);
        break;
      case Op::footer:
        take_footer(place);
        break;
      case Op::chunk_index:
      case Op::attachment_index:
      case Op::metadata_index:
      case Op::statistics:
      case Op::summary_offset:
        report(ProblemKind::bad_record, place.offset, "a record of the summary stands before DataEnd");
        break;
      default:
        break;  // unknown records are skipped
    }
  }

  bool content_of(const RecordWalk::Place& place) {
    FileProblem problem;
    if (!read_bytes(file_, place.offset, place.length, limits_, bytes_, problem)) {
      scan_.problems.push_back(problem);
      return false;
    }
    content_ = bytes_.bytes().subspan(kRecordHead);
    return true;
  }
  void too_short(const RecordWalk::Place& place, const char* what) {
    report(ProblemKind::bad_record, place.offset, std::string("the fields of the ") + what + " are longer than it");
  }

  void take_header(const RecordWalk::Place& place) {
    if (content_of(place) && !decode(content_, scan_.header)) too_short(place, "header");
  }

  void take_data_end(const RecordWalk::Place& place) {
    if (place.length != kRecordHead + 4) return report(ProblemKind::bad_record, place.offset, "a DataEnd has 4 bytes");
    scan_.whole = true, scan_.data_end = place.offset;
    if (content_of(place)) scan_.data_crc = Cursor(content_).number<std::uint32_t>();
  }
  /// A DataEnd must come before it, although the examples of the specification leave it out.
  void take_footer(const RecordWalk::Place& place) {
    if (place.length != kFooterBytes || place.offset + kFileTail != file_.size())
      return report(ProblemKind::bad_record, place.offset, "a footer stands before the end of the file");
    scan_.whole = true, scan_.data_end = place.offset;
  }

  void take_chunk(const RecordWalk::Place& place) {
    Block block{.offset = place.offset, .length = place.length, .channels = {}};
    chunked_ = true;
    if (!take_block(block)) {
      block.start_time = 0, block.end_time = ~std::uint64_t{0};  // readers of any time must see it
      scan_.blocks.push_back(std::move(block));
      return;
    }
    const ChunkHead& head = *chunk_.head();
    if (head.start_time != block.start_time || head.end_time != block.end_time)
      report(ProblemKind::bad_index, place.offset, "the chunk's times are not those of its messages");
    ChunkIndex index{.start_time = block.start_time,
                     .end_time = block.end_time,
                     .offset = place.offset,
                     .length = place.length,
                     .message_indexes = {},
                     .message_index_length = 0,
                     .compression = head.compression,
                     .compressed_size = head.records_size,
                     .uncompressed_size = head.uncompressed_size};
    scan_.summary.chunks.push_back(std::move(index));
    scan_.blocks.push_back(std::move(block));
    indexed_ = true;
  }

  /// Loads a block and counts its content. False: it cannot be used.
  bool take_block(Block& block) {
    FileProblem problem;
    if (!chunk_.load(file_, block, limits_, decompressor_, problem) ||
        !merge_definitions(chunk_.schemas(), chunk_.channels(), block.offset, scan_.summary, problem)) {
      scan_.problems.push_back(problem);
      return false;
    }
    block.start_time = chunk_.start_time(), block.end_time = chunk_.end_time();
    block.judged = true;
    if (!chunk_.entries().empty()) {
      first_time_ = std::min(first_time_, block.start_time);
      totals_.end_time = std::max(totals_.end_time, block.end_time);
    }
    places_.clear();
    for (const auto& entry : chunk_.entries()) places_[entry.channel].emplace_back(entry.log_time, entry.place);
    for (const auto& [channel, places] : places_) {
      block.channels.push_back(channel);
      totals_.channel_messages[channel] += places.size();
      totals_.messages += places.size();
      if (!scan_.summary.channels.contains(channel))
        report(
            ProblemKind::unknown_channel, block.offset,
            std::to_string(places.size()) + " messages of channel " + std::to_string(channel) + ", not defined before");
    }
    return true;
  }

  void take_message_index(const RecordWalk::Place& place) {
    if (!indexed_) return;  // its chunk is not readable, or there is no chunk
    if (!content_of(place)) return;
    ChunkIndex& chunk = scan_.summary.chunks.back();
    Cursor cursor(content_);
    const auto channel = cursor.number<std::uint16_t>();
    Cursor entries(cursor.take(cursor.number<std::uint32_t>()));
    std::vector<std::pair<std::uint64_t, std::uint64_t>> said;
    while (entries.rest().size() >= 16) {
      const auto time = entries.number<std::uint64_t>();
      said.emplace_back(time, entries.number<std::uint64_t>());
    }
    std::sort(said.begin(), said.end());
    auto& found = places_[channel];
    std::sort(found.begin(), found.end());
    if (!cursor.good() || said != found)
      report(ProblemKind::bad_index, place.offset, "the message index is not that of the chunk before it");
    if (!said.empty() || !found.empty()) chunk.message_indexes.emplace(channel, place.offset);
    chunk.message_index_length += place.length;
  }

  void end_indexes() {
    if (!indexed_) return;
    indexed_ = false;
    const ChunkIndex& chunk = scan_.summary.chunks.back();
    if (chunk.message_index_length == 0) return;  // the file has none
    for (const auto& [channel, places] : places_)
      if (!places.empty() && !chunk.message_indexes.contains(channel))
        report(ProblemKind::bad_index, chunk.offset,
               "no message index for channel " + std::to_string(channel) + " behind the chunk");
  }

  void end_loose() {
    if (loose_.length == 0) return;
    Block block = std::exchange(loose_, {});
    if (!take_block(block)) block.start_time = 0, block.end_time = ~std::uint64_t{0};
    scan_.blocks.push_back(std::move(block));
  }

  void take_attachment(const RecordWalk::Place& place) {
    ++totals_.attachments;
    if (!content_of(place)) return;
    Attachment attachment;
    std::uint32_t crc = 0, computed = 0;
    if (!decode(content_, attachment, crc, computed)) return too_short(place, "attachment");
    if (crc != 0 && crc != computed)
      return report(ProblemKind::bad_checksum, place.offset, "the attachment's bytes are not those that were written");
    scan_.summary.attachments.push_back({place.offset, place.length, attachment.log_time, attachment.create_time,
                                         attachment.data.size(), attachment.name, attachment.media_type});
  }

  void take_metadata(const RecordWalk::Place& place) {
    ++totals_.metadata;
    if (!content_of(place)) return;
    Metadata metadata;
    if (!decode(content_, metadata)) return too_short(place, "metadata");
    scan_.summary.metadata.push_back({place.offset, place.length, metadata.name});
  }

  void finish() {
    end_indexes();
    const Summary& s = scan_.summary;
    totals_.schemas = static_cast<std::uint16_t>(s.schemas.size());
    totals_.channels = static_cast<std::uint32_t>(s.channels.size());
    totals_.chunks = static_cast<std::uint32_t>(s.chunks.size());
    totals_.start_time = totals_.messages == 0 ? 0 : first_time_;
    for (const auto& [id, channel] : s.channels) totals_.channel_messages.try_emplace(id, 0);
    scan_.summary.statistics = totals_;
  }

  hal::InputFile& file_;
  ReadLimits limits_;
  Scan scan_;
  ChunkContents chunk_;
  Decompressor decompressor_;
  Buffer bytes_;
  std::span<const std::byte> content_;
  Block loose_;
  Op last_{};
  bool chunked_ = false;  // there has been a chunk
  bool indexed_ = false;  // the last chunk is readable and its indexes may follow
  std::map<std::uint16_t, std::vector<std::pair<std::uint64_t, std::uint64_t>>> places_;  // in the last block
  Statistics totals_;
  std::uint64_t first_time_ = ~std::uint64_t{0};
};

}  // namespace

Scan scan(hal::InputFile& file, const ReadLimits& limits) { return Scanner(file, limits).run(); }

}  // namespace sinew::record
