#include "apps/sweep/case_text.hpp"

#include <algorithm>

namespace sinew::sweep {
namespace {

constexpr std::string_view kSeed = "--seed";

std::string quoted_word(const std::string& word) {
  constexpr std::string_view kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+./,:=@%";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\"'\"'") : std::string(1, c);
  return quoted + "'";
}

}  // namespace

std::optional<std::vector<std::string>> split_words(std::string_view line) {
  std::vector<std::string> words;
  bool in_word = false;
  char quote = 0;
  for (const char c : line) {
    const bool blank = c == ' ' || c == '\t' || c == '\r';
    if (quote == 0 && blank) {
      in_word = false;
      continue;
    }
    if (!in_word) words.emplace_back(), in_word = true;
    if (quote != 0 ? c == quote : c == '\'' || c == '"')
      quote = quote != 0 ? 0 : c;
    else
      words.back() += c;
  }
  if (quote != 0) return std::nullopt;
  return words;
}

std::string joined(const std::vector<std::string>& words) {
  std::string line;
  for (const std::string& word : words) line += (line.empty() ? "" : " ") + quoted_word(word);
  return line;
}

std::vector<std::string> parts_of(std::string_view run) {
  const auto words = split_words(run).value_or(std::vector<std::string>{std::string(run)});
  std::vector<std::vector<std::string>> parts;
  for (const std::string& word : words) {
    if (parts.empty() || word.starts_with("--") || !parts.back().front().starts_with("--") || parts.back().size() == 2)
      parts.emplace_back();
    parts.back().push_back(word);
  }
  std::vector<std::string> texts(parts.size());
  std::transform(parts.begin(), parts.end(), texts.begin(), joined);
  return texts;
}

std::optional<std::string> seed_of(std::string_view run) {
  const auto words = split_words(run);
  if (!words) return std::nullopt;
  for (std::size_t i = 0; i + 1 < words->size(); ++i)
    if ((*words)[i] == kSeed) return (*words)[i + 1];
  return std::nullopt;
}

std::string without_seed(std::string_view run) {
  std::string rest;
  for (const std::string& part : parts_of(run))
    if (!part.starts_with("--seed ")) rest += (rest.empty() ? "" : " ") + part;
  return rest;
}

}  // namespace sinew::sweep
