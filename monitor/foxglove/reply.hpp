#pragma once
// Replies of robots, as a session reads them. Inside of the room only: it shows the JSON library.
#include <nlohmann/json.hpp>
#include <string>

namespace sinew::foxglove {

using Json = nlohmann::ordered_json;

/// Empty: the text is no JSON object.
Json object_of(const std::string& text);
/// Why a reply says no; empty: it says yes.
std::string error_of(const Json& reply);
/// An empty list, an empty text: there is no such member.
const Json& list_of(const Json& reply, const char* member);
std::string text_of(const Json& object, const char* member);

/// Bytes that are not UTF-8 are replaced.
std::string one_line(const Json& json);

}  // namespace sinew::foxglove
