#include "hal/did_you_mean.hpp"

#include <algorithm>

namespace sinew::hal {
namespace {

constexpr std::size_t kFar = 1000;         // no difference of two names that resemble each other
constexpr std::size_t kLongestName = 100;  // of those that are compared: the time goes with the square

std::string folded(std::string_view name) {
  std::string text(name);
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    if (c == '-') c = '_';
  }
  return text;
}

/// Letters to insert, to remove, to replace, or neighbours to exchange, that make `b` of `a`.
/// Source:  optimal string alignment distance: https://en.wikipedia.org/wiki/Damerau-Levenshtein_distance
std::size_t edits(const std::string& a, const std::string& b) {
  const std::size_t width = b.size() + 1;
  std::vector<std::size_t> before(width), last(width), row(width);
  for (std::size_t j = 0; j < width; ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j < width; ++j) {
      const std::size_t replaced = last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      row[j] = std::min({replaced, last[j] + 1, row[j - 1] + 1});
      const bool exchanged = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (exchanged) row[j] = std::min(row[j], before[j - 2] + 1);
    }
    std::swap(before, last);
    std::swap(last, row);
  }
  return last[b.size()];
}

/// "search_height" of "search_height_m", "Mixer" of "control::Mixer", "raw" of "imu.raw".
bool is_part(const std::string& asked, const std::string& name) {
  if (asked.size() < 2 || asked.size() >= name.size()) return false;
  if (name.starts_with(asked)) return name[asked.size()] == '_' || name[asked.size()] == '.';
  const char joint = name[name.size() - asked.size() - 1];
  return name.ends_with(asked) && (joint == ':' || joint == '.');
}

/// "Mixer" of "control::Mixer"; the whole of a name without a namespace.
std::string last_part(const std::string& name) {
  const auto at = name.rfind("::");
  return at == std::string::npos ? name : name.substr(at + 2);
}

std::size_t difference(const std::string& asked, const std::string& name) {
  if (asked == name) return 0;
  if (name.size() > kLongestName) return kFar;
  const std::size_t most = asked.size() < 2 ? 0 : std::clamp<std::size_t>(asked.size() / 3, 1, 3);
  const std::size_t found = edits(asked, name);
  if (found <= most) return found;
  if (is_part(asked, name)) return most + 1;
  const std::size_t without_namespace = edits(asked, last_part(name));
  return without_namespace <= most ? most + 1 + without_namespace : kFar;
}

}  // namespace

std::vector<std::string> near_names(std::string_view asked, std::span<const std::string> names) {
  constexpr std::size_t kMost = 2;
  std::vector<std::string> nearest;
  if (asked.size() > kLongestName) return nearest;
  const std::string wanted = folded(asked);
  std::size_t least = kFar;
  for (const std::string& name : names) {
    const std::size_t d = difference(wanted, folded(name));
    if (d >= kFar || d > least) continue;
    if (d < least) nearest.clear();
    least = d;
    if (nearest.size() < kMost && std::find(nearest.begin(), nearest.end(), name) == nearest.end())
      nearest.push_back(name);
  }
  return nearest;
}

std::string did_you_mean(std::string_view asked, std::span<const std::string> names) {
  const std::vector<std::string> nearest = near_names(asked, names);
  if (nearest.empty()) return {};
  std::string text = "; did you mean " + nearest.front();
  if (nearest.size() > 1) text += " or " + nearest.back();
  return text + "?";
}

std::string quoted(std::span<const std::string> names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "\"" : ", \"") + name + '"';
  return list;
}

}  // namespace sinew::hal
