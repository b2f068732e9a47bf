#include "wire/text/usarsim.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace sinew::wire {
namespace {

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

std::string_view usar_trimmed(std::string_view text) {
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

/// The next word of `rest`, which loses it; empty: none is left.
std::string_view next_word(std::string_view& rest) {
  rest = usar_trimmed(rest);
  std::size_t n = 0;
  while (n < rest.size() && !is_space(rest[n])) ++n;
  const std::string_view word = rest.substr(0, n);
  rest.remove_prefix(n);
  return word;
}

/// "Name F1 Range 0.5": at least two keys, each with one word behind it.
bool has_several_keys(std::string_view content) {
  std::size_t words = 0;
  for (std::string_view rest = content, word; !(word = next_word(rest)).empty(); ++words)
    if (words % 2 == 0 && !is_letter(word.front())) return false;
  return words >= 4 && words % 2 == 0;
}

bool add_part(UsarLine& out, std::string_view key, std::string_view value, std::uint32_t brace) {
  if (out.count == out.part.size()) return false;
  out.part[out.count++] = {key, value, brace};
  return true;
}

bool add_brace(UsarLine& out, std::string_view content, std::uint32_t brace) {
  content = usar_trimmed(content);
  if (content.empty()) return true;
  if (!has_several_keys(content)) {
    std::string_view rest = content;
    const std::string_view key = next_word(rest);
    return add_part(out, key, usar_trimmed(rest), brace);
  }
  for (std::string_view rest = content, key; !(key = next_word(rest)).empty();)
    if (!add_part(out, key, next_word(rest), brace)) return false;
  return true;
}

}  // namespace

std::size_t UsarLine::index_of(std::string_view key, std::size_t from) const noexcept {
  for (std::size_t i = from; i < count; ++i)
    if (part[i].key == key) return i;
  return count;
}

UsarPart UsarLine::find(std::string_view key, std::size_t from) const noexcept {
  const std::size_t i = index_of(key, from);
  return i < count ? part[i] : UsarPart{};
}

UsarError parse_usarsim(std::string_view line, UsarLine& out) noexcept {
  out.type = {};
  out.count = 0;
  std::string_view rest = usar_trimmed(line);
  if (rest.empty()) return UsarError::empty;
  std::size_t n = 0;
  while (n < rest.size() && !is_space(rest[n]) && rest[n] != '{' && rest[n] != '}') ++n;
  if (n == 0) return rest.front() == '{' ? UsarError::text : UsarError::brace;
  out.type = rest.substr(0, n);
  rest.remove_prefix(n);
  for (std::uint32_t brace = 0;; ++brace) {
    rest = usar_trimmed(rest);
    if (rest.empty()) return UsarError::none;
    if (rest.front() == '}') return UsarError::brace;
    if (rest.front() != '{') return UsarError::text;
    const std::size_t end = rest.find_first_of("{}", 1);
    if (end == std::string_view::npos || rest[end] == '{') return UsarError::brace;
    if (!add_brace(out, rest.substr(1, end - 1), brace)) return UsarError::too_many;
    rest.remove_prefix(end + 1);
  }
}

namespace {

/// The items of a value, one after the other: one comma (or semicolon) between two, blanks around it; blanks alone also
/// divide.
class Items {
 public:
  Items(std::string_view value, bool decimal_comma) : rest_(usar_trimmed(value)), comma_cuts_(!decimal_comma) {}
  bool next(std::string_view& item) {
    if (rest_.empty()) return false;
    std::size_t n = 0;
    while (n < rest_.size() && !is_space(rest_[n]) && !is_cut(rest_[n])) ++n;
    item = rest_.substr(0, n);
    rest_ = usar_trimmed(rest_.substr(n));
    if (!rest_.empty() && is_cut(rest_.front())) rest_ = usar_trimmed(rest_.substr(1));
    return true;
  }

 private:
  bool is_cut(char c) const { return c == ';' || (c == ',' && comma_cuts_); }
  std::string_view rest_;
  bool comma_cuts_;
};

}  // namespace

std::string_view usar_item(std::string_view value, std::size_t index, bool decimal_comma) noexcept {
  Items items(value, decimal_comma);
  for (std::string_view item; items.next(item); --index)
    if (index == 0) return item;
  return {};
}

std::size_t usar_count(std::string_view value, bool decimal_comma) noexcept {
  Items items(value, decimal_comma);
  std::size_t count = 0;
  for (std::string_view item; items.next(item);) ++count;
  return count;
}

std::optional<double> parse_number(std::string_view text) noexcept {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  if (text.empty() || (text.front() == '+')) return std::nullopt;
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<double> usar_number(std::string_view value, std::size_t index, bool decimal_comma) noexcept {
  std::string_view item = usar_item(value, index, decimal_comma);
  if (item == "True" || item == "true") return 1;
  if (item == "False" || item == "false") return 0;
  std::array<char, 64> copy;
  if (!decimal_comma || item.size() > copy.size()) return parse_number(item);
  std::replace_copy(item.begin(), item.end(), copy.begin(), ',', '.');
  return parse_number({copy.data(), item.size()});
}

bool UsarLines::push(char c) noexcept {
  if (complete_) size_ = 0, complete_ = false;
  if (c == '\r' || c == '\n') {
    if (bad_) {
      bad_ = false;
      size_ = 0;
      ++dropped_;
      return false;
    }
    complete_ = size_ > 0;
    return complete_;
  }
  if (bad_) return false;
  if (size_ == text_.size() || (static_cast<unsigned char>(c) < 0x20 && c != '\t') || c == 0x7f) {
    bad_ = true;
    return false;
  }
  text_[size_++] = c;
  return false;
}

bool UsarLines::reset() noexcept {
  const bool begun = (size_ > 0 && !complete_) || bad_;
  size_ = 0;
  bad_ = complete_ = false;
  return begun;
}

UsarWriter& UsarWriter::put(std::string_view text) noexcept {
  if (!fits_ || text.size() > into_.size() - used_) {
    fits_ = false;
    return *this;
  }
  std::copy(text.begin(), text.end(), into_.begin() + static_cast<std::ptrdiff_t>(used_));
  used_ += text.size();
  return *this;
}

UsarWriter& UsarWriter::put(double value, int decimals) noexcept {
  std::array<char, 352> digits;
  const std::size_t n = write_fixed(std::isfinite(value) ? value : 0, decimals, digits);
  return put({digits.data(), n});
}

UsarWriter& UsarWriter::type(std::string_view type) noexcept { return put(type); }
UsarWriter& UsarWriter::text(std::string_view key, std::string_view value) noexcept {
  return put(" {").put(key).put(" ").put(value).put("}");
}
UsarWriter& UsarWriter::number(std::string_view key, double value, int decimals) noexcept {
  return put(" {").put(key).put(" ").put(value, decimals).put("}");
}
UsarWriter& UsarWriter::integer(std::string_view key, std::int64_t value) noexcept {
  std::array<char, 24> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  return text(key, {digits.data(), static_cast<std::size_t>(end - digits.data())});
}
UsarWriter& UsarWriter::vector(std::string_view key, std::span<const double> values, int decimals) noexcept {
  put(" {").put(key).put(" ");
  for (std::size_t i = 0; i < values.size(); ++i) put(i == 0 ? "" : ",").put(values[i], decimals);
  return put("}");
}
UsarWriter& UsarWriter::open() noexcept {
  first_word_ = true;
  return put(" {");
}
UsarWriter& UsarWriter::word(std::string_view word) noexcept {
  put(first_word_ ? "" : " ").put(word);
  first_word_ = false;
  return *this;
}
UsarWriter& UsarWriter::word(double value, int decimals) noexcept {
  put(first_word_ ? "" : " ").put(value, decimals);
  first_word_ = false;
  return *this;
}
UsarWriter& UsarWriter::close() noexcept { return put("}"); }

std::string_view UsarWriter::line() noexcept {
  put("\r\n");
  return fits_ ? std::string_view{into_.data(), used_} : std::string_view{};
}

std::size_t write_fixed(double value, int decimals, std::span<char> out) noexcept {
  if (!std::isfinite(value)) return 0;
  const auto [end, error] =
      std::to_chars(out.data(), out.data() + out.size(), value, std::chars_format::fixed, std::clamp(decimals, 0, 17));
  return error == std::errc{} ? static_cast<std::size_t>(end - out.data()) : 0;
}

}  // namespace sinew::wire
