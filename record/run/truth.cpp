#include "record/run/truth.hpp"

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "msg/cdr.hpp"
#include "msg/ros2msg.hpp"
#include "record/run/quantity.hpp"

namespace sinew::record {
namespace {

constexpr rt::Duration kMostApart = std::chrono::seconds(1);

const Channel* channel_of(const Reader& reader, const std::string& topic) {
  for (const auto& [id, channel] : reader.channels())
    if (channel.topic == topic) return &channel;
  return nullptr;
}

/// The type of the schema "sinew_msgs/msg/NavState", if this program knows it.
const msg::TypeInfo* type_of(const Reader& reader, const rt::Graph& graph, const Channel& channel, std::string& why) {
  const auto schema = reader.schemas().find(channel.schema);
  const std::string name = schema == reader.schemas().end() ? "" : schema->second.name;
  const msg::TypeInfo* type = graph.message_type(name.substr(name.rfind('/') + 1));
  if (!type || type->has_bulk() || msg::ros2_name(*type) != name)
    why = "topic " + channel.topic + ": \"" + name + "\" is no message of this program to compare with";
  else if (schema->second.data != msg::ros2msg_schema(*type))
    why = "topic " + channel.topic + ": recorded with another version of " + name;
  else
    return type;
  return nullptr;
}

std::optional<rt::Time> stamp_of(const msg::TypeInfo& type, const void* message) {
  for (const msg::FieldInfo& f : type.fields) {
    if (f.name != "stamp" || f.kind != msg::Kind::i64 || f.is_array) continue;
    rt::Time stamp;
    std::memcpy(&stamp, static_cast<const std::byte*>(message) + f.offset, sizeof stamp);
    return stamp;
  }
  return std::nullopt;
}

}  // namespace

std::string Truth::topic_of(const Reader& reader) {
  for (const auto& [id, channel] : reader.channels())
    if (channel.topic == kTruthTopic || channel.topic.starts_with(std::string(kTruthTopic) + ".")) return channel.topic;
  return {};
}

std::optional<Truth> Truth::read(Reader& reader, const rt::Graph& graph, const std::string& topic, std::string& why) {
  const Channel* channel = channel_of(reader, topic);
  if (!channel) {
    why = "no topic " + topic + " in the file";
    return std::nullopt;
  }
  const msg::TypeInfo* type = type_of(reader, graph, *channel, why);
  if (!type) return std::nullopt;
  Truth truth(*type);
  std::vector<std::byte> bytes(type->size);
  MessageReader messages = reader.messages({.topics = {topic}});
  Message m;
  for (Next next; (next = messages.next(m)) != Next::end;) {
    if (next == Next::problem) continue;  // the replay reports it
    type->reset(bytes.data());
    if (!msg::cdr_decode(*type, {reinterpret_cast<const std::uint8_t*>(m.data.data()), m.data.size()}, bytes.data()))
      continue;
    const auto stamp = stamp_of(*type, bytes.data());
    if (!stamp || (!truth.stamps_.empty() && *stamp <= truth.stamps_.back())) continue;
    truth.stamps_.push_back(*stamp);
    truth.bytes_.insert(truth.bytes_.end(), bytes.begin(), bytes.end());
  }
  if (!truth.stamps_.empty()) return truth;
  why = "topic " + topic + ": no messages with a stamp";
  return std::nullopt;
}

bool Truth::at(rt::Time stamp, void* message_out) const {
  const auto after = std::lower_bound(stamps_.begin(), stamps_.end(), stamp);
  if (after == stamps_.end()) return false;
  const auto i = static_cast<std::size_t>(after - stamps_.begin());
  if (*after == stamp) {
    std::memcpy(message_out, message(i), type_->size);
    return true;
  }
  if (i == 0 || *after - stamps_[i - 1] > kMostApart) return false;
  const double share =
      static_cast<double>((stamp - stamps_[i - 1]).count()) / static_cast<double>((*after - stamps_[i - 1]).count());
  interpolate(*type_, message(i - 1), message(i), share, message_out);
  return true;
}

}  // namespace sinew::record
