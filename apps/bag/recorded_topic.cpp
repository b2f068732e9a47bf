#include "apps/bag/recorded_topic.hpp"

#include <fmt/format.h>

#include "msg/ros2msg.hpp"

namespace sinew::app {

std::optional<std::string> topic_of_type(const record::Reader& reader, const msg::TypeInfo& type,
                                         const TopicChoice& choice, std::string& why) {
  const std::string wanted = msg::ros2_name(type);
  std::string all;
  std::optional<std::string> found;
  std::size_t fitting = 0;
  for (const auto& [id, channel] : reader.channels()) {
    const auto schema = reader.schemas().find(channel.schema);
    if (schema == reader.schemas().end() || schema->second.name != wanted || !channel.topic.starts_with(choice.prefix))
      continue;
    const std::string name = channel.topic.substr(choice.prefix.size());
    all += (all.empty() ? "" : ", ") + name;
    if (!choice.named.empty() && name != choice.named) continue;
    if (schema->second.data != msg::ros2msg_schema(type)) {
      why = fmt::format("topic {}: recorded with another version of {}", channel.topic, wanted);
      return std::nullopt;
    }
    found = channel.topic;
    ++fitting;
  }
  if (fitting == 1) return found;
  if (fitting > 1)
    why = fmt::format("it has several topics of {}: {}; choose one with {}", wanted, all, choice.option);
  else if (choice.named.empty())
    why = "it has no topic of " + wanted;
  else
    why = fmt::format("{} {}: there is none; it has: {}", choice.option, choice.named, all.empty() ? "none" : all);
  return std::nullopt;
}

}  // namespace sinew::app
