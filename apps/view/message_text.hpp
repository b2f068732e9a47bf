#pragma once
#include <nlohmann/json.hpp>
#include <string>

namespace sinew::app {

/// A JSON object for people: one `key: value` a line, nested ones indented, arrays of numbers on one line.
std::string indented_text(const nlohmann::ordered_json& json);

/// The part of a message that a path names: "p_world_m.x", "value.0". Null when there is none; `why` then says what
/// there is.
const nlohmann::ordered_json* find_field(const nlohmann::ordered_json& message, const std::string& path,
                                         std::string& why);

}  // namespace sinew::app
