#include "record/summary.hpp"

#include "record/crc32.hpp"

namespace sinew::record {
namespace {

/// Appends the records of one kind and notes their places.
template <class Records, class Encode>
void group(Buffer& to, Op op, std::uint64_t at, const Records& records, std::vector<SummaryOffset>& offsets,
           const Encode& put) {
  const std::size_t begin = to.size();
  for (const auto& record : records) put(record);
  if (to.size() != begin) offsets.push_back({op, at + begin, to.size() - begin});
}

}  // namespace

void encode_end(Buffer& to, const Summary& summary, std::uint64_t at) {
  at -= to.size();  // `to` may hold what precedes the summary
  const std::size_t begin = to.size();
  std::vector<SummaryOffset> offsets;
  const auto value = [&to](const auto& entry) { encode(to, entry.second); };
  const auto record = [&to](const auto& entry) { encode(to, entry); };
  group(to, Op::schema, at, summary.schemas, offsets, value);
  group(to, Op::channel, at, summary.channels, offsets, value);
  group(to, Op::statistics, at, std::span(&summary.statistics, 1), offsets, [&to](const auto& entry) {
    if (entry) encode(to, *entry);
  });
  group(to, Op::chunk_index, at, summary.chunks, offsets, record);
  group(to, Op::attachment_index, at, summary.attachments, offsets, record);
  group(to, Op::metadata_index, at, summary.metadata, offsets, record);
  const std::size_t offsets_begin = to.size();
  for (const SummaryOffset& offset : offsets) encode(to, offset);

  to.number(static_cast<std::uint8_t>(Op::footer));
  to.number(std::uint64_t{kFooterBytes - kRecordHead});
  to.number(offsets.empty() ? std::uint64_t{0} : at + begin);
  to.number(offsets.empty() ? std::uint64_t{0} : at + offsets_begin);
  to.number(crc32(to.bytes().subspan(begin)));
  to.append(kMagic);
}

}  // namespace sinew::record
