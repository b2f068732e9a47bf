#include "rt/graph_spec.hpp"

namespace sinew::rt {

std::string topic_name(std::string_view module, std::string_view port) {
  if (is_remote(port) || module.empty()) return std::string(port);
  return port.empty() ? std::string(module) : std::string(module) + "." + std::string(port);
}

std::string to_string(const Problem& problem, std::string_view file) {
  std::string text(file);
  if (problem.line > 0) text += ':' + std::to_string(problem.line);
  return text + ": " + problem.key + ": " + problem.value + ": " + problem.allowed;
}

std::pair<std::string_view, std::string_view> split_topic(std::string_view name) {
  const auto dot = name.find('.');
  if (dot == std::string_view::npos) return {name, {}};
  return {name.substr(0, dot), name.substr(dot + 1)};
}

}  // namespace sinew::rt
