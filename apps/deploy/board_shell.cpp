#include "apps/deploy/board_shell.hpp"

#include <algorithm>

namespace sinew::app {

std::string shell_quoted(std::string_view text) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'')
      out += "'\\''";
    else
      out += c;
  }
  return out + "'";
}

std::string shell_line(std::string_view script, const std::vector<std::string>& arguments, bool root) {
  std::string line = root ? "sudo -n sh -c " : "sh -c ";
  line += shell_quoted(script) + " sinew";
  for (const auto& a : arguments) line += " " + shell_quoted(a);
  return line;
}

std::vector<std::string> split_words(std::string_view text) {
  std::vector<std::string> words;
  for (std::size_t at = 0; (at = text.find_first_not_of(" \t", at)) != std::string_view::npos;) {
    const auto end = std::min(text.find_first_of(" \t", at), text.size());
    words.emplace_back(text.substr(at, end - at));
    at = end;
  }
  return words;
}

MarkedText::MarkedText(std::string_view text) {
  constexpr std::string_view kMark = "::sinew ";
  for (std::size_t at = 0; at < text.size();) {
    const auto end = std::min(text.find('\n', at), text.size());
    const auto line = text.substr(at, end - at);
    if (line.starts_with(kMark))
      parts_.push_back({std::string(line.substr(kMark.size())), {}});
    else if (!parts_.empty())
      parts_.back().body += std::string(line) + "\n";
    at = end + 1;
  }
}

std::optional<std::string> MarkedText::after(std::string_view mark) const {
  for (const auto& part : parts_)
    if (part.mark == mark) return part.body;
  return std::nullopt;
}

std::optional<std::string> MarkedText::word_after(std::string_view word) const {
  for (const auto& part : parts_)
    if (part.mark.starts_with(word) && part.mark.size() > word.size() && part.mark[word.size()] == ' ')
      return part.mark.substr(word.size() + 1);
  return std::nullopt;
}

}  // namespace sinew::app
