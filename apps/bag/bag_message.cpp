#include "apps/bag/bag_message.hpp"

#include <cstdio>

#include "msg/all.hpp"
#include "msg/ros2msg.hpp"
#include "record/run/ros2_json.hpp"
#include "record/run/run_messages.hpp"

namespace sinew::app {
namespace {

constexpr std::string_view kOurs = "sinew_msgs/msg/";

/// This program's definition of the type `name`; empty: it has none.
std::string our_text(std::string_view name) {
  for (const auto* schema :
       {&record::step_batch_schema(), &record::request_schema(), &record::state_schema(), &record::image_head_schema()})
    if (schema->name == name) return std::string(schema->text);
  if (!name.starts_with(kOurs)) return {};
  const msg::TypeInfo* type = msg::find_type(name.substr(kOurs.size()));
  return type && !type->has_bulk() ? msg::ros2msg_schema(*type) : std::string();
}

void note(const std::string& topic, const std::string& text) {
  std::fprintf(stderr, "%s: %s\n", topic.c_str(), text.c_str());
}

}  // namespace

BagMessages::Known& BagMessages::of(const record::Channel& channel) {
  const auto [at, is_new] = channels_.try_emplace(channel.id);
  Known& known = at->second;
  if (!is_new) return known;
  const auto schema = reader_.schemas().find(channel.schema);
  std::string why;
  if (schema == reader_.schemas().end())
    why = "its messages have no schema";
  else if (channel.message_encoding != "cdr" || schema->second.encoding != "ros2msg")
    why = "messages in \"" + channel.message_encoding + "\" by a schema in \"" + schema->second.encoding +
          "\"; known are \"cdr\" by \"ros2msg\"";
  else
    known.schema = record::Ros2Schema::parse(schema->second.name, schema->second.data, why);
  if (!known.schema) {
    note(channel.topic, "not shown: " + why);
    known.said = true;
  } else if (const std::string ours = our_text(schema->second.name);
             !ours.empty() && !record::same_definition(ours, schema->second.data)) {
    note(channel.topic, "its " + schema->second.name + " is another version than this program's; shown as recorded");
  }
  return known;
}

const record::Ros2Schema* BagMessages::schema(const record::Channel& channel) {
  const Known& known = of(channel);
  return known.schema ? &*known.schema : nullptr;
}

bool BagMessages::append_json(const record::Message& message, std::string& out) {
  Known& known = of(*message.channel);
  if (known.schema && record::to_json(*known.schema, message.data, out)) return true;
  ++unknown_;
  if (!known.said) note(message.channel->topic, "not shown: its bytes do not fit their schema");
  known.said = true;
  return false;
}

}  // namespace sinew::app
