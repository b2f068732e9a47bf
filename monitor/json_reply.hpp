#pragma once
// Replies in JSON, as docs/monitor.md has them. Inside of the room only: it shows the JSON library.
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "monitor/http/server.hpp"

namespace sinew::monitor {

using Json = nlohmann::ordered_json;

/// In one line; bytes that are not UTF-8 are replaced.
std::string to_text(const Json& json);

Response json_response(int status, const std::string& text);
/// As a robot's socket refuses: {"ok": false, "error": {"code", "why"}}.
Response json_error(int status, std::string_view code, std::string_view why);

/// The body of a request; nothing, with `refusal`: it is no JSON object. Forms of other sites cannot send this type
/// without asking first, which nobody here permits.
std::optional<Json> json_body(const Request& request, Response& refusal);
/// A member that is text; empty: it is none.
std::string text_of(const Json& object, const char* name);

/// The HTTP status that goes with the reply of a robot's socket.
int status_of(const Json& reply);

}  // namespace sinew::monitor
