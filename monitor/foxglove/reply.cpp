#include "monitor/foxglove/reply.hpp"

namespace sinew::foxglove {

Json object_of(const std::string& text) {
  Json json = Json::parse(text, nullptr, false);
  return json.is_object() ? json : Json::object();
}

std::string error_of(const Json& reply) {
  const auto ok = reply.find("ok");
  if (ok != reply.end() && ok->is_boolean() && ok->get<bool>()) return {};
  const auto error = reply.find("error");
  if (error == reply.end() || !error->is_object()) return "no reply that can be understood";
  return error->value("why", std::string("refused"));
}

const Json& list_of(const Json& reply, const char* member) {
  static const Json kNone = Json::array();
  const auto at = reply.find(member);
  return at != reply.end() && at->is_array() ? *at : kNone;
}

std::string text_of(const Json& object, const char* member) {
  if (!object.is_object()) return {};
  const auto at = object.find(member);
  return at != object.end() && at->is_string() ? at->get<std::string>() : std::string();
}

std::string one_line(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

}  // namespace sinew::foxglove
