#include "monitor/json_reply.hpp"

#include <utility>

namespace sinew::monitor {

std::string to_text(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

Response json_response(int status, const std::string& text) {
  Response r;
  r.status = status, r.media_type = "application/json", r.body = bytes_of(text + "\n");
  r.headers = {{"cache-control", "no-store"}};
  return r;
}

Response json_error(int status, std::string_view code, std::string_view why) {
  return json_response(status, to_text({{"ok", false}, {"error", {{"code", code}, {"why", why}}}}));
}

std::optional<Json> json_body(const Request& request, Response& refusal) {
  if (!request.content_type.starts_with("application/json")) {
    refusal = json_error(415, "bad_argument", "the body's content-type has to be application/json");
    return std::nullopt;
  }
  Json body = request.body.empty() ? Json::object() : Json::parse(request.body, nullptr, false);
  if (body.is_object()) return body;
  refusal = json_error(400, "bad_argument", "the body has to be a JSON object");
  return std::nullopt;
}

std::string text_of(const Json& object, const char* name) {
  const auto member = object.find(name);
  return member != object.end() && member->is_string() ? member->get<std::string>() : std::string();
}

int status_of(const Json& reply) {
  static constexpr std::pair<std::string_view, int> kStatus[] = {
      {"not_found", 404}, {"busy", 409},    {"denied", 403}, {"not_supported", 501}, {"bad_argument", 400},
      {"bad_data", 502},  {"timeout", 504}, {"closed", 410}, {"out_of_memory", 503}, {"io", 502}};
  const auto is = [](const Json& object, const char* name) {
    const auto member = object.find(name);
    return member != object.end() && member->is_boolean() && member->get<bool>();
  };
  if (is(reply, "ok")) return 200;
  const auto error = reply.find("error");
  if (error == reply.end() || !error->is_object()) return 502;
  const auto code = error->find("code");
  if (code == error->end() || !code->is_string()) return 502;
  for (const auto& [name, status] : kStatus)
    if (name == code->get_ref<const std::string&>()) return status;
  return 500;
}

}  // namespace sinew::monitor
