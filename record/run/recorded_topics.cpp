#include "record/run/recorded_topics.hpp"

#include <algorithm>

#include "msg/all.hpp"
#include "msg/image.hpp"
#include "msg/ros2msg.hpp"
#include "record/ros2_schema.hpp"
#include "record/run/run_messages.hpp"
#include "rt/segment.hpp"

namespace sinew::record {
namespace {

/// Size of a slot, from the first head of the topic's images; 0: there is no head.
std::uint32_t image_bytes(Reader& reader, const std::string& topic) {
  auto heads = reader.messages({.topics = {topic + std::string(kHeadSuffix)}, .order = Order::file});
  Message m;
  ImageHead head;
  constexpr std::uint32_t kMost = msg::kMaxImageWidth * msg::kMaxImageHeight * 3;
  for (Next next; (next = heads.next(m)) != Next::end;)
    if (next == Next::message && decode(m.data, head)) return std::min(head.capacity_bytes, kMost);
  return 0;
}

double mean_rate_hz(const Reader& reader, const Channel& channel) {
  const auto& all = reader.statistics();
  if (!all || all->end_time <= all->start_time) return 0;
  const auto count = all->channel_messages.find(channel.id);
  if (count == all->channel_messages.end()) return 0;
  return static_cast<double>(count->second) / (1e-9 * static_cast<double>(all->end_time - all->start_time));
}

/// Why messages of this channel cannot be put back into memory; empty: they can, and `topic` has the type.
std::string look(Reader& reader, const Channel& channel, RecordedTopic& topic) {
  constexpr std::string_view kOurPrefix = "sinew_msgs/msg/";
  constexpr std::size_t kLongestName = sizeof(rt::TopicEntry::name) - 1;
  if (channel.topic.size() > kLongestName) return "a name longer than " + std::to_string(kLongestName) + " letters";
  const auto schema = reader.schemas().find(channel.schema);
  if (schema == reader.schemas().end() || channel.message_encoding != "cdr")
    return "messages without a schema, or not in CDR";
  const std::string& name = schema->second.name;
  if (name == image_schema().name) {
    topic.type = &msg::type_info<msg::Image>();
    topic.image_bytes = image_bytes(reader, channel.topic);
    return topic.image_bytes > 0 ? "" : "images without heads";
  }
  topic.type = name.starts_with(kOurPrefix) ? msg::find_type(name.substr(kOurPrefix.size())) : nullptr;
  if (!topic.type || topic.type->has_bulk()) return name + ": no message type of this program";
  if (!same_definition(msg::ros2msg_schema(*topic.type), schema->second.data))
    return name + ": defined otherwise in this program";
  return {};
}

}  // namespace

RecordedTopics recorded_topics(Reader& reader) {
  RecordedTopics all;
  for (const auto& entry : reader.channels()) {
    const Channel& channel = entry.second;
    const std::string& name = channel.topic;
    if (name == kStepsTopic || name == kRequestsTopic || name == kStatesTopic) continue;
    const auto schema = reader.schemas().find(channel.schema);
    if (schema != reader.schemas().end() && schema->second.name == image_head_schema().name) continue;
    const auto same = [&name](const auto& topic) { return topic.name == name; };
    if (std::any_of(all.known.begin(), all.known.end(), same)) continue;  // a second channel of the same topic
    RecordedTopic topic{name, nullptr, 0, mean_rate_hz(reader, channel)};
    if (std::string why = look(reader, channel, topic); why.empty())
      all.known.push_back(std::move(topic));
    else
      all.unknown.push_back({name, std::move(why)});
  }
  return all;
}

}  // namespace sinew::record
