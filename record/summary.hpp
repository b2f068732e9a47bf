#pragma once
#include <map>
#include <vector>

#include "record/format.hpp"

namespace sinew::record {

/// The summary at the end of a file.
struct Summary {
  std::map<std::uint16_t, Schema> schemas;
  std::map<std::uint16_t, Channel> channels;
  std::vector<ChunkIndex> chunks;  // in the order of the file
  std::vector<AttachmentIndex> attachments;
  std::vector<MetadataIndex> metadata;
  std::optional<Statistics> statistics;
};

/// The end of a file whose data section, DataEnd included, is `at` bytes long: summary, offsets, footer, magic.
void encode_end(Buffer& to, const Summary& summary, std::uint64_t at);

}  // namespace sinew::record
