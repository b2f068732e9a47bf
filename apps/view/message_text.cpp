#include "apps/view/message_text.hpp"

#include <charconv>

namespace sinew::app {
namespace {

using Json = nlohmann::ordered_json;

void add(const Json& json, std::size_t indent, std::string& out) {
  for (const auto& [key, value] : json.items()) {
    out += std::string(indent, ' ') + key + ":";
    if (value.is_object()) {
      out += "\n";
      add(value, indent + 2, out);
    } else {
      out += " " + (value.is_string() ? value.get<std::string>() : value.dump()) + "\n";
    }
  }
}

// One step of a path; null when it leads nowhere.
const Json* step_into(const Json& json, const std::string& key) {
  if (json.is_object()) {
    const auto at = json.find(key);
    return at == json.end() ? nullptr : &*at;
  }
  std::size_t index = 0;
  const auto read = std::from_chars(key.data(), key.data() + key.size(), index);
  if (!json.is_array() || read.ec != std::errc() || read.ptr != key.data() + key.size() || index >= json.size())
    return nullptr;
  return &json[index];
}

std::string choices(const Json& json) {
  if (json.is_array()) return json.empty() ? "it is empty" : "an index from 0 to " + std::to_string(json.size() - 1);
  if (!json.is_object()) return "there is nothing inside it";
  std::string names = "one of";
  for (const auto& [key, value] : json.items()) names += " " + key;
  return names;
}

}  // namespace

std::string indented_text(const Json& json) {
  std::string out;
  add(json, 0, out);
  return out;
}

const Json* find_field(const Json& message, const std::string& path, std::string& why) {
  const Json* at = &message;
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find('.', begin), path.size());
    const std::string key = path.substr(begin, end - begin);
    const Json* inner = step_into(*at, key);
    if (!inner) {
      why = path + ": no \"" + key + "\"; " + choices(*at);
      return nullptr;
    }
    at = inner;
    begin = end + 1;
  }
  return at;
}

}  // namespace sinew::app
