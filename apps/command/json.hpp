#pragma once
#include <nlohmann/json.hpp>
#include <string>

namespace sinew::app {

using Json = nlohmann::ordered_json;

/// One object on one line.
std::string to_line(const Json& json);

}  // namespace sinew::app
