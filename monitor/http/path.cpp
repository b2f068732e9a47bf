#include "monitor/http/path.hpp"

#include <algorithm>

namespace sinew::monitor {

bool is_plain_path(std::string_view path) {
  if (path.empty() || path[0] != '/' || path.size() > 1024) return false;
  if (std::any_of(path.begin(), path.end(), [](char c) { return c < ' ' || c == '\x7f' || c == '\\'; })) return false;
  while (!path.empty()) {
    path.remove_prefix(1);
    const std::size_t slash = path.find('/');
    const std::string_view part = path.substr(0, slash);
    if (part == "." || part == ".." || (part.empty() && slash != std::string_view::npos)) return false;
    path = slash == std::string_view::npos ? std::string_view() : path.substr(slash);
  }
  return true;
}

}  // namespace sinew::monitor
