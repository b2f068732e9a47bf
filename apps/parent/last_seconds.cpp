#include "apps/parent/last_seconds.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <vector>

#include "apps/parent/run_folder.hpp"
#include "msg/json.hpp"
#include "tap/segment_reader.hpp"

namespace sinew::app {
namespace {

namespace fs = std::filesystem;

struct Line {
  std::int64_t published_ns = 0;
  std::string text;
};

void read_topic(const tap::SegmentReader& reader, std::uint32_t index, std::vector<Line>& lines) {
  const tap::Topic& topic = reader.topics()[index];
  const auto newest = reader.newest(index);
  if (!newest || !topic.known()) return;
  std::vector<std::byte> copy(reader.bytes(index));
  for (std::uint32_t back = topic.keep; back-- > 0;) {  // one by one: a young topic has no oldest ones
    const std::uint32_t sequence = newest->sequence - back;
    tap::Cursor cursor{sequence, true, 0};
    const auto message = reader.next(index, cursor);
    if (!message || message->sequence != sequence) continue;
    if (!reader.copy(*message, copy)) continue;
    rt::SlotHeader header;
    std::memcpy(&header, copy.data(), sizeof(header));
    Line line{header.published.ns, fmt::format(R"({{"topic":"{}","sequence":{},"published_ns":{},"message":)",
                                               topic.name, message->sequence, header.published.ns)};
    msg::to_json(*topic.info, copy.data() + sizeof(header), line.text);
    line.text += "}\n";
    lines.push_back(std::move(line));
  }
}

std::string messages_of(std::span<const std::byte> memory) {
  const auto reader = tap::SegmentReader::open(memory);
  if (!reader) return {};
  std::vector<Line> lines;
  for (std::uint32_t t = 0; t < reader->topics().size(); ++t) read_topic(*reader, t, lines);
  std::stable_sort(lines.begin(), lines.end(),
                   [](const Line& a, const Line& b) { return a.published_ns < b.published_ns; });
  std::string text;
  for (const Line& line : lines) text += line.text;
  return text;
}

bool write_file(const fs::path& path, const char* data, std::size_t bytes, std::string& why) {
  std::ofstream out(path, std::ios::binary);
  out.write(data, static_cast<std::streamsize>(bytes));
  out.close();
  if (!out) why = path.string() + ": cannot be written";
  return !out.fail();
}

}  // namespace

std::string save_last_seconds(const std::string& folder, std::string_view robot, std::string_view fault,
                              std::span<const std::byte> memory, std::string& why) {
  const std::time_t now = std::time(nullptr);
  const fs::path path = make_run_folder(folder, robot, why);
  if (path.empty()) return {};
  const std::string messages = messages_of(memory);
  const std::string about =
      fmt::format("{{\"robot\":\"{}\",\"fault\":\"{}\",\"noticed_utc\":\"{:%Y-%m-%dT%H:%M:%SZ}\",\"messages\":{}}}\n",
                  robot, fault, fmt::gmtime(now), std::count(messages.begin(), messages.end(), '\n'));
  const auto* bytes = reinterpret_cast<const char*>(memory.data());
  const bool good = write_file(path / "fault.json", about.data(), about.size(), why) &&
                    write_file(path / "messages.jsonl", messages.data(), messages.size(), why) &&
                    write_file(path / "topics.bin", bytes, memory.size(), why);
  return good ? path.string() : std::string();
}

}  // namespace sinew::app
