// Any bytes as an MCAP file: opened or refused, read in both orders, checked and recovered, always within the file and
// the limits, with every message inside its query, in order. A recovered file is whole.
#include <cstdlib>

#include "memory_file.hpp"
#include "record/check.hpp"
#include "record/recover.hpp"

using namespace sinew::record;

namespace {

constexpr ReadLimits kLimits{.record_bytes = 4 << 20, .open_bytes = 16 << 20};

std::uint64_t read(Reader& reader, const Query& query) {
  MessageReader messages = reader.messages(query);
  Message m;
  std::uint64_t count = 0, last = 0, sum = 0;
  for (;;) switch (messages.next(m)) {
      case Next::end:
        return count;
      case Next::problem:
        if (to_string(messages.problem()).empty()) std::abort();
        break;
      case Next::message:
        if (m.stamps.log_time < query.from || m.stamps.log_time > query.until) std::abort();
        if (query.order == Order::log_time && m.stamps.log_time < last) std::abort();
        last = m.stamps.log_time;
        for (const std::byte b : m.data) sum += std::to_integer<unsigned>(b);  // every byte is there to be read
        ++count;
        if (m.channel->topic == "\x01" && sum == 1) std::abort();
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  FileProblem why;
  auto reader = Reader::open(std::make_unique<MemoryInput>(bytes), why, kLimits);
  MemoryInput input(bytes);
  check(input, kLimits);
  if (!reader) return 0;
  const std::uint64_t count = read(*reader, {.order = Order::file});
  read(*reader, {});
  read(*reader, {.from = 1010, .until = 1100});
  Attachment attachment;
  Metadata metadata;
  for (const auto& index : reader->attachments()) static_cast<void>(reader->read(index, attachment, why));
  for (const auto& index : reader->metadata()) static_cast<void>(reader->read(index, metadata, why));
  if (size % 4 != 0) return 0;  // writing costs ten times what reading does
  Disk disk;
  Recovered result;
  if (!recover(std::make_unique<MemoryInput>(bytes), std::make_unique<MemoryOutput>(disk), result, kLimits))
    std::abort();
  MemoryInput recovered(disk.bytes);
  if (result.messages != count || !check(recovered).empty()) std::abort();
  return 0;
}
