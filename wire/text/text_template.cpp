#include "wire/text/text_template.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>

#include "wire/text_scan.hpp"

namespace sinew::wire {
namespace {

constexpr std::string_view kConversions = "diufFeEgGsbq%";
constexpr double kMostWhole = 9e18;

/// The digits of one value, without sign and padding.
struct Digits {
  std::array<char, 352> text;
  std::size_t size = 0;
  bool negative = false;
};

bool whole(double value, Digits& out) {
  if (!(std::fabs(value) <= kMostWhole)) return false;
  const auto n = static_cast<std::uint64_t>(std::fabs(value) + 0.5);
  out.negative = value < 0 && n != 0;
  out.size = static_cast<std::size_t>(std::to_chars(out.text.data(), out.text.data() + out.text.size(), n).ptr -
                                      out.text.data());
  return true;
}

bool real(double value, char kind, int precision, Digits& out) {
  if (!std::isfinite(value)) return false;
  const bool upper = kind < 'a';
  const char lower = static_cast<char>(kind | 0x20);
  const auto format = lower == 'f'   ? std::chars_format::fixed
                      : lower == 'e' ? std::chars_format::scientific
                                     : std::chars_format::general;
  out.negative = std::signbit(value);
  const auto [end, error] = std::to_chars(out.text.data(), out.text.data() + out.text.size(), std::fabs(value), format,
                                          precision < 0 ? 6 : precision);
  if (error != std::errc{}) return false;
  out.size = static_cast<std::size_t>(end - out.text.data());
  if (upper) std::replace(out.text.data(), out.text.data() + out.size, 'e', 'E');
  return true;
}

bool bits_of(double value, Digits& out) {
  const auto narrow = static_cast<float>(value);
  if (!std::isfinite(narrow)) return false;
  const auto bits = std::bit_cast<std::int32_t>(narrow);
  out.negative = bits < 0;
  const std::uint32_t size = bits < 0 ? 0u - static_cast<std::uint32_t>(bits) : static_cast<std::uint32_t>(bits);
  out.size = static_cast<std::size_t>(std::to_chars(out.text.data(), out.text.data() + out.text.size(), size).ptr -
                                      out.text.data());
  return true;
}

void put_repeated(TextPut& out, char c, std::size_t times) {
  for (; times > 0; --times) out.put({&c, 1});
}

}  // namespace

std::optional<std::size_t> TextTemplate::parse_conversion(std::string_view text, Piece& piece, std::string& why) {
  std::size_t i = 1;  // behind the %
  for (bool flag = true; flag && i < text.size();) {
    switch (text[i]) {
      case '-':
        piece.left = true;
        break;
      case '+':
        piece.plus = true;
        break;
      case ' ':
        piece.blank = true;
        break;
      case '0':
        piece.zero = true;
        break;
      default:
        flag = false;
    }
    if (flag) ++i;
  }
  const auto number = [&](int most) {
    int n = 0;
    for (; i < text.size() && text[i] >= '0' && text[i] <= '9'; ++i) n = std::min(10 * n + (text[i] - '0'), most + 1);
    return n;
  };
  piece.width = number(kWidest);
  if (i < text.size() && text[i] == '.') {
    ++i;
    piece.precision = number(kMostPrecise);
  }
  const std::string shown(text.substr(0, std::min(i + 1, text.size())));
  if (i >= text.size() || kConversions.find(text[i]) == std::string_view::npos) {
    why = "\"" + shown + "\" is no conversion of commands; those are %d %i %u %f %e %g %s %b %q %%";
    return std::nullopt;
  }
  piece.kind = text[i];
  const bool is_real = std::string_view("fFeEgG").find(piece.kind) != std::string_view::npos;
  if (piece.width > kWidest || piece.precision > kMostPrecise) {
    why = "\"" + shown + "\": a width of at most 64, and a precision of at most 17";
    return std::nullopt;
  }
  if (piece.precision >= 0 && !is_real) {
    why = "\"" + shown + "\": only %f, %e and %g have a precision";
    return std::nullopt;
  }
  if (piece.kind == '%' && i != 1) {
    why = "\"" + shown + "\": a per cent sign is %%, with nothing between";
    return std::nullopt;
  }
  return i + 1;
}

std::optional<TextTemplate> TextTemplate::parse(std::string_view text, std::vector<std::string> words,
                                                std::string& why) {
  if (text.size() > kLongest) {
    why = "at most 1000 characters";
    return std::nullopt;
  }
  TextTemplate made;
  made.text_ = text;
  made.words_ = std::move(words);
  for (std::size_t at = 0; at < text.size();) {
    Piece piece;
    piece.begin = static_cast<std::uint32_t>(at);
    if (text[at] != '%') {
      const std::size_t end = std::min(text.find('%', at), text.size());
      piece.size = static_cast<std::uint32_t>(end - at);
      at = end;
    } else {
      const auto size = parse_conversion(text.substr(at), piece, why);
      if (!size) return std::nullopt;
      at += *size;
      if (piece.kind == '%') piece.kind = 0, piece.begin += 1, piece.size = 1;
    }
    if (piece.kind == 'q') made.has_sequence_ = true;
    if (piece.kind != 0 && piece.kind != 'q') ++made.values_;
    if (piece.kind == 's' && made.words_.empty()) {
      why = "%s needs words to choose from";
      return std::nullopt;
    }
    made.pieces_.push_back(piece);
  }
  return made;
}

std::size_t TextTemplate::write(std::span<const double> values, std::uint32_t& sequence,
                                std::span<char> out) const noexcept {
  if (values.size() < values_) return 0;
  TextPut put(out);
  Digits digits;
  std::size_t next = 0;
  for (const Piece& piece : pieces_) {
    std::string_view body;
    digits.negative = false;
    if (piece.kind == 0) {
      put.put(std::string_view(text_).substr(piece.begin, piece.size));
      continue;
    }
    if (piece.kind == 's') {
      const double value = values[next++];
      if (!(value > -0.5 && value < static_cast<double>(words_.size()) - 0.5)) return 0;
      body = words_[static_cast<std::size_t>(value + 0.5)];
    } else {
      bool good = true;
      if (piece.kind == 'q')
        good = whole(static_cast<double>(sequence++), digits);
      else if (piece.kind == 'd' || piece.kind == 'i')
        good = whole(values[next++], digits);
      else if (piece.kind == 'u')
        good = whole(values[next], digits) && !digits.negative, ++next;
      else if (piece.kind == 'b')
        good = bits_of(values[next++], digits);
      else
        good = real(values[next++], piece.kind, piece.precision, digits);
      if (!good) return 0;
      body = {digits.text.data(), digits.size};
    }
    const bool is_number = piece.kind != 's';
    std::string_view sign;
    if (is_number && digits.negative)
      sign = "-";
    else if (is_number && piece.kind != 'u' && piece.kind != 'q' && (piece.plus || piece.blank))
      sign = piece.plus ? "+" : " ";
    const std::size_t size = sign.size() + body.size(), width = static_cast<std::size_t>(piece.width);
    const std::size_t fill = width > size ? width - size : 0;
    const bool zeros = piece.zero && !piece.left && is_number;
    if (!zeros && !piece.left) put_repeated(put, ' ', fill);
    put.put(sign);
    if (zeros) put_repeated(put, '0', fill);
    put.put(body);
    if (piece.left) put_repeated(put, ' ', fill);
  }
  return put.size();
}

}  // namespace sinew::wire
