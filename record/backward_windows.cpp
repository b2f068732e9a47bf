#include "record/backward_windows.hpp"

#include <algorithm>

namespace sinew::record {

std::optional<Query> BackwardWindows::next(const std::vector<std::string>& topics) {
  if (!until_ || topics.empty()) return std::nullopt;
  std::set<std::uint16_t> wanted;
  for (const auto& [id, channel] : reader_.channels())
    if (std::find(topics.begin(), topics.end(), channel.topic) != topics.end()) wanted.insert(id);
  std::optional<std::uint64_t> from;
  for (const Block& block : reader_.blocks()) {
    if (block.start_time > *until_ || (from && block.start_time <= *from)) continue;
    const bool may_have = block.channels.empty() || std::any_of(block.channels.begin(), block.channels.end(),
                                                                [&](auto id) { return wanted.contains(id); });
    if (may_have) from = block.start_time;
  }
  if (!from) return std::nullopt;
  Query query{.topics = topics, .from = *from, .until = *until_};
  if (*from == 0)
    until_.reset();
  else
    until_ = *from - 1;
  return query;
}

}  // namespace sinew::record
