#include "sim_hil/usarsim/values.hpp"

#include <algorithm>

namespace sinew::usarsim {

using math::Vec3;

namespace {

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

/// Three numbers out of six items, each pair the sides of a decimal comma.
std::optional<Vec3> pairs(std::string_view value) {
  Vec3 v;
  for (int i = 0; i < 3; ++i) {
    const std::string both = std::string(wire::usar_item(value, static_cast<std::size_t>(2 * i))) + "." +
                             std::string(wire::usar_item(value, static_cast<std::size_t>(2 * i + 1)));
    const auto number = wire::parse_number(both);
    if (!number) return std::nullopt;
    v[i] = *number;
  }
  return v;
}

}  // namespace

bool same_word(std::string_view a, std::string_view b) {
  return std::ranges::equal(a, b, [](char x, char y) { return lower(x) == lower(y); });
}

std::optional<std::string_view> value_of(const wire::UsarLine& line, std::string_view key) {
  for (const wire::UsarPart& part : line.parts())
    if (same_word(part.key, key)) return part.value;
  return std::nullopt;
}

std::string text_of(const wire::UsarLine& line, std::string_view key) {
  return std::string(value_of(line, key).value_or(""));
}

std::optional<double> number_in(std::string_view value) {
  const bool comma = wire::usar_count(value) == 2 && wire::usar_count(value, true) == 1;
  if (!comma && wire::usar_count(value) != 1) return std::nullopt;
  return wire::usar_number(value, 0, comma);
}

std::optional<double> number_of(const wire::UsarLine& line, std::string_view key) {
  const auto value = value_of(line, key);
  return value ? number_in(*value) : std::nullopt;
}

std::optional<Vec3> vector_of(const wire::UsarLine& line, std::string_view key) {
  const auto value = value_of(line, key);
  if (!value) return std::nullopt;
  const std::size_t items = wire::usar_count(*value), with_commas = wire::usar_count(*value, true);
  const bool comma = items != 3 && with_commas == 3;
  if (!comma && items == 6) return pairs(*value);
  if (!comma && items != 3) return std::nullopt;
  Vec3 v;
  for (int i = 0; i < 3; ++i) {
    const auto number = wire::usar_number(*value, static_cast<std::size_t>(i), comma);
    if (!number) return std::nullopt;
    v[i] = *number;
  }
  return v;
}

std::optional<bool> flag_of(const wire::UsarLine& line, std::string_view key) {
  const auto value = value_of(line, key);
  if (!value) return std::nullopt;
  if (same_word(*value, "true") || *value == "1") return true;
  if (same_word(*value, "false") || *value == "0") return false;
  return std::nullopt;
}

std::optional<bool> is_rate(std::optional<double> order) {
  if (!order || *order == 0) return false;
  return *order == 1 ? std::optional(true) : std::nullopt;
}

std::string clean(std::string_view text) {
  constexpr std::size_t kMost = 200;
  std::string all(text.substr(0, kMost));
  for (char& c : all)
    if (c == '{' || c == '}' || static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  return all;
}

}  // namespace sinew::usarsim
