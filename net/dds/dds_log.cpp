#include "net/dds/dds_log.hpp"

#include <dds/ddsrt/log.h>

#include <deque>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "net/dds/participant.hpp"

namespace sinew::net {
namespace {

constexpr std::size_t kMostLogLines = 64;

struct LogLines {
  std::mutex mutex;
  std::deque<std::string> lines;
};

LogLines& log_lines() {
  static auto* all = new LogLines;  // Cyclone's threads may end after main
  return *all;
}

void keep_line(void*, const dds_log_data_t* data) {
  std::string line(data->message, data->size);
  while (!line.empty() && (line.back() == '\n' || line.back() == ' ')) line.pop_back();
  if (line.empty()) return;
  LogLines& all = log_lines();
  const std::lock_guard lock(all.mutex);
  if (!all.lines.empty() && all.lines.back() == line) return;
  all.lines.push_back(std::move(line));
  if (all.lines.size() > kMostLogLines) all.lines.pop_front();
}

}  // namespace

void keep_dds_log() {
  static std::once_flag once;
  std::call_once(once, [] {
    dds_set_log_sink(keep_line, nullptr);
    dds_set_trace_sink([](void*, const dds_log_data_t*) {}, nullptr);  // where the same lines would be printed
  });
}

std::vector<std::string> take_dds_log() {
  LogLines& all = log_lines();
  const std::lock_guard lock(all.mutex);
  std::vector<std::string> out(all.lines.begin(), all.lines.end());
  all.lines.clear();
  return out;
}

}  // namespace sinew::net
