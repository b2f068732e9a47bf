#include "net/ros2/bridge_spec.hpp"

#include <algorithm>

namespace sinew::ros2 {
namespace {

bool is_token(std::string_view token) {
  const auto is_word = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  };
  return !token.empty() && !(token.front() >= '0' && token.front() <= '9') &&
         std::all_of(token.begin(), token.end(), is_word) && token.find("__") == token.npos;
}

}  // namespace

bool is_node_name(std::string_view name) { return name.size() <= 100 && is_token(name); }

bool is_ros_name(std::string_view name) {
  if (name.size() > 200) return false;
  if (name.starts_with("~/"))
    name.remove_prefix(2);
  else if (name.starts_with('/'))
    name.remove_prefix(1);
  for (;;) {
    const auto end = name.find('/');
    if (!is_token(name.substr(0, end))) return false;
    if (end == name.npos) return true;
    name.remove_prefix(end + 1);
  }
}

std::string node_path(const BridgeSpec& spec) {
  return (spec.name_space == "/" ? "" : spec.name_space) + "/" + spec.node;
}

std::string full_name(const BridgeSpec& spec, std::string_view ros) {
  if (ros.starts_with('/')) return std::string(ros);
  if (ros.starts_with("~/")) return node_path(spec) + std::string(ros.substr(1));
  return (spec.name_space == "/" ? "" : spec.name_space) + "/" + std::string(ros);
}

std::string dds_topic(std::string_view full_name) { return "rt" + std::string(full_name); }

}  // namespace sinew::ros2
