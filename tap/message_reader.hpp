#pragma once
// Messages that come in as JSON. Inside of the room only: it shows the JSON library.
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "msg/describe.hpp"

namespace sinew::tap {

/// Fills a message from an object as msg::to_json() writes it. Fields left out keep their defaults; unknown fields,
/// numbers out of range and arrays of another length are refused. Not for types with bulk, which nobody sends so.
/// Errors:  what is wrong, where and what is allowed: "gyro_radps.x: \"fast\": a number, \"NaN\", ..."; the message is
///          then at its defaults.
std::optional<std::string> read_message(const msg::TypeInfo& type, const nlohmann::ordered_json& object, void* message);

}  // namespace sinew::tap
