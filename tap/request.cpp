#include "tap/request.hpp"

#include "tap/frames.hpp"

namespace sinew::tap {

Reply good(const Json& members) {
  Json json = Json::object();
  json["ok"] = true;
  json.update(members);
  return {std::move(json)};
}

Json refused(hal::Errc code, const std::string& why) {
  return {{"ok", false}, {"error", {{"code", code_name(code)}, {"why", why}}}};
}

Reply refuse(hal::Errc code, const std::string& why) { return {refused(code, why)}; }

Reply needs(const char* member, const char* what) {
  return refuse(hal::Errc::bad_argument, std::string("\"") + member + "\": " + what);
}

const std::string* text_of(const Json& request, const char* member) {
  const auto at = request.find(member);
  return at != request.end() ? at->get_ptr<const std::string*>() : nullptr;
}

std::string to_text(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

std::string to_text(const Reply& reply) {
  std::string text = to_text(reply.json);
  if (reply.long_member.empty()) return text;
  text.reserve(text.size() + 1 + reply.long_member.size());
  text.back() = ',';
  return text.append(reply.long_member).append(1, '}');
}

}  // namespace sinew::tap
