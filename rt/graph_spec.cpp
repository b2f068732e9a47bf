#include "rt/graph_spec.hpp"

namespace sinew::rt {

std::string to_string(const Problem& problem, std::string_view file) {
  std::string text(file);
  text += ':' + std::to_string(problem.line) + ": " + problem.key + ": " + problem.value + ": " + problem.allowed;
  return text;
}

}  // namespace sinew::rt
