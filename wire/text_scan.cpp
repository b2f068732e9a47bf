#include "wire/text_scan.hpp"

#include <algorithm>

namespace sinew::wire {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

std::optional<std::uint32_t> digit_of(char c) {
  if (c >= '0' && c <= '9') return static_cast<std::uint32_t>(c - '0');
  if (c >= 'a' && c <= 'f') return static_cast<std::uint32_t>(c - 'a' + 10);
  if (c >= 'A' && c <= 'F') return static_cast<std::uint32_t>(c - 'A' + 10);
  return std::nullopt;
}

}  // namespace

bool TextScan::take(char c) noexcept {
  if (rest_.empty() || rest_.front() != c) return false;
  rest_.remove_prefix(1);
  return true;
}

void TextScan::skip_blanks() noexcept {
  while (!rest_.empty() && is_blank(rest_.front())) rest_.remove_prefix(1);
}

std::string_view TextScan::word() noexcept {
  skip_blanks();
  std::size_t n = 0;
  while (n < rest_.size() && !is_blank(rest_[n])) ++n;
  const std::string_view found = rest_.substr(0, n);
  rest_.remove_prefix(n);
  return found;
}

std::optional<std::uint32_t> TextScan::hex_digit() noexcept {
  const auto digit = rest_.empty() ? std::nullopt : digit_of(rest_.front());
  if (digit) rest_.remove_prefix(1);
  return digit;
}

std::optional<std::uint8_t> TextScan::hex_byte() noexcept {
  if (rest_.size() < 2) return std::nullopt;
  const auto high = digit_of(rest_[0]), low = digit_of(rest_[1]);
  if (!high || !low) return std::nullopt;
  rest_.remove_prefix(2);
  return static_cast<std::uint8_t>(*high << 4 | *low);
}

std::optional<std::uint32_t> parse_hex(std::string_view text, std::size_t digits) noexcept {
  if (text.empty() || text.size() > digits) return std::nullopt;
  std::uint32_t value = 0;
  for (const char c : text) {
    const auto digit = digit_of(c);
    if (!digit) return std::nullopt;
    value = value << 4 | *digit;
  }
  return value;
}

std::optional<std::uint64_t> parse_decimal(std::string_view text, std::size_t digits) noexcept {
  if (text.empty() || text.size() > digits) return std::nullopt;
  std::uint64_t value = 0;
  for (const char c : text) {
    if (c < '0' || c > '9') return std::nullopt;
    value = value * 10 + static_cast<std::uint64_t>(c - '0');
  }
  return value;
}

std::optional<std::int64_t> parse_seconds(std::string_view text) noexcept {
  const std::size_t dot = text.find('.');
  if (dot == std::string_view::npos) return std::nullopt;
  // Nine digits of seconds would end in 2001; ten reach to 2286 and fit in 64 bits of nanoseconds up to 2262.
  const auto whole = parse_decimal(text.substr(0, dot), 10);
  const std::string_view fraction = text.substr(dot + 1);
  const auto parts = parse_decimal(fraction, 9);
  if (!whole || !parts || *whole > 9'000'000'000ull) return std::nullopt;
  std::uint64_t ns = *parts;
  for (std::size_t i = fraction.size(); i < 9; ++i) ns *= 10;
  return static_cast<std::int64_t>(*whole * 1'000'000'000ull + ns);
}

TextPut& TextPut::put(std::string_view text) noexcept {
  if (!fits_ || text.size() > into_.size() - used_) {
    fits_ = false;
    return *this;
  }
  std::copy(text.begin(), text.end(), into_.begin() + static_cast<std::ptrdiff_t>(used_));
  used_ += text.size();
  return *this;
}

TextPut& TextPut::hex(std::uint32_t value, int digits) noexcept {
  for (int shift = 4 * (digits - 1); shift >= 0; shift -= 4)
    put(std::string_view(&"0123456789ABCDEF"[value >> shift & 15], 1));
  return *this;
}

TextPut& TextPut::decimal(std::uint64_t value, int digits) noexcept {
  char text[20];
  int n = 0;
  do {
    text[n++] = static_cast<char>('0' + value % 10);
    value /= 10;
  } while (value != 0 || n < digits);
  while (n > 0) put(std::string_view(&text[--n], 1));
  return *this;
}

TextPut& TextPut::seconds(std::int64_t ns) noexcept {
  const std::uint64_t us = static_cast<std::uint64_t>(ns < 0 ? 0 : ns) / 1000;
  return decimal(us / 1'000'000).put(".").decimal(us % 1'000'000, 6);
}

}  // namespace sinew::wire
