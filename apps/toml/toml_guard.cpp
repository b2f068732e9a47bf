#include "apps/toml/toml_guard.hpp"

#include <algorithm>

namespace sinew::app {
namespace {

bool beyond_ascii(char c) { return static_cast<unsigned char>(c) >= 0x80; }

/// The index behind the comment or string that starts at `at`, or `at` itself when none does. A string ends early where
/// the parser gives up on it, too: at a character beyond ASCII, and, on one line, at the end of the line.
std::size_t behind_text(std::string_view text, std::size_t at) {
  if (text[at] == '#') return std::min(text.find('\n', at), text.size());
  if (text[at] != '"' && text[at] != '\'') return at;
  const std::string_view quote = text.substr(at, 1);
  const bool many_lines = text.substr(at, 3) == std::string_view(quote == "\"" ? "\"\"\"" : "'''");
  const std::string_view end = text.substr(at, many_lines ? 3 : 1);
  for (std::size_t i = at + end.size(); i < text.size(); ++i) {
    if (text[i] == '\\' && quote == "\"" && !beyond_ascii(text[std::min(i + 1, text.size() - 1)]))
      ++i;
    else if (text.substr(i, end.size()) == end)
      return i + end.size();
    else if (beyond_ascii(text[i]) || (text[i] == '\n' && !many_lines))
      return i;
  }
  return text.size();
}

}  // namespace

int line_beyond_ascii(std::string_view text) {
  int line = 1;
  for (std::size_t i = 0; i < text.size();) {
    if (beyond_ascii(text[i])) return line;
    const std::size_t next = std::max(behind_text(text, i), i + 1);
    line += static_cast<int>(std::count(text.begin() + i, text.begin() + next, '\n'));
    i = next;
  }
  return 0;
}

}  // namespace sinew::app
