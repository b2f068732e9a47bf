#pragma once
#include <functional>
#include <map>
#include <vector>

#include "record/copy.hpp"

namespace sinew::record {

/// Copies a whole file, message by message in their order. `change` may alter the data of a message, and returns false
/// to leave it out. `renew` may alter the text of schemas. The caller finishes `to`. False: a part of it could not be
/// read or written.
template <class F>
[[nodiscard]] bool rewrite(
    Reader& from, Writer& to, F&& change, const std::function<void(Schema&)>& renew = [](Schema&) {}) {
  Reader* const one = &from;
  Copied copied;
  if (!copy({&one, 1}, {.topics = {"nothing but metadata and attachments"}}, to, copied)) return false;
  std::map<std::uint16_t, std::uint16_t> channels;
  for (const auto& [id, c] : from.channels()) {
    Schema s = from.schemas().at(c.schema);
    renew(s);
    const auto schema = to.add_schema(s.name, s.encoding, s.data);
    if (!schema) return false;
    const auto channel = to.add_channel(c.topic, c.message_encoding, *schema, c.metadata);
    if (!channel) return false;
    channels[id] = *channel;
  }
  auto messages = from.messages({.order = Order::file});
  Message m;
  for (Next next; (next = messages.next(m)) != Next::end;) {
    if (next != Next::message) return false;
    std::vector<std::byte> data(m.data.begin(), m.data.end());
    if (change(m, data) && !to.write(channels.at(m.channel->id), m.stamps, data)) return false;
  }
  return true;
}

}  // namespace sinew::record
