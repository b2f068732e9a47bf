#pragma once
// Topics of a recording by the type of their messages.
#include <optional>
#include <string>
#include <string_view>

#include "msg/cdr.hpp"
#include "msg/describe.hpp"
#include "record/reader.hpp"

namespace sinew::app {

struct TopicChoice {
  std::string_view prefix{};            // of topics that count; what follows it is the name
  std::string named{};                  // empty: the only one
  std::string_view option = "--topic";  // where the user names it
};

/// The topic with messages of this type. Nothing, with `why`: there is none, there are several, or it was recorded by
/// another version of the type.
std::optional<std::string> topic_of_type(const record::Reader& reader, const msg::TypeInfo& type,
                                         const TopicChoice& choice, std::string& why);
template <msg::Described M>
std::optional<std::string> topic_of(const record::Reader& reader, const TopicChoice& choice, std::string& why) {
  return topic_of_type(reader, msg::type_info<M>(), choice, why);
}

/// Calls `each` with each message of a topic of this type, in their order. What is missing in the file is missing.
template <msg::Described M, class Each>
void each_of(record::Reader& reader, const std::string& topic, const Each& each) {
  record::MessageReader messages = reader.messages({.topics = {topic}});
  record::Message m;
  for (record::Next next; (next = messages.next(m)) != record::Next::end;) {
    if (next == record::Next::problem) continue;
    M message{};
    if (msg::cdr_decode(msg::type_info<M>(), {reinterpret_cast<const std::uint8_t*>(m.data.data()), m.data.size()},
                        &message))
      each(message);
  }
}

}  // namespace sinew::app
