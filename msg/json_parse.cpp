// The reading half of msg/json.hpp. It parses only what the description announces, so its depth is that of the type.
#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <limits>
#include <vector>

#include "msg/json.hpp"
#include "msg/text.hpp"

namespace sinew::msg {
namespace {

class Parser {
 public:
  Parser(std::string_view text, std::uint8_t* bulk, std::uint32_t capacity)
      : text_(text), bulk_(bulk), capacity_(capacity) {}

  bool message(const TypeInfo& type, std::byte* p) {
    if (!object(type, p, "", true)) return false;
    skip_space();
    return at_ == text_.size() || fail("", "text behind the message", "nothing");
  }
  std::uint32_t bulk_bytes() const { return bulk_bytes_; }
  JsonError take_error() { return std::move(error_); }

 private:
  bool fail(const std::string& path, std::string what, std::string allowed) {
    error_ = {at_, path, std::move(what), std::move(allowed)};
    return false;
  }
  void skip_space() {
    while (at_ < text_.size() && std::string_view(" \t\r\n").find(text_[at_]) != std::string_view::npos) ++at_;
  }
  bool accept(char c) {
    skip_space();
    if (at_ == text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }
  bool expect(char c, const std::string& path) {
    return accept(c) || fail(path, found(), "'" + std::string(1, c) + "'");
  }
  /// The text found here, for an error.
  std::string found() {
    skip_space();
    if (at_ == text_.size()) return "end of the text";
    return std::string(text_.substr(at_, std::min<std::size_t>(text_.find_first_of(",]}\n", at_ + 1) - at_, 24)));
  }
  /// A string without escapes: neither names nor the texts in messages need them.
  bool string(std::string_view& value) {
    if (!accept('"')) return false;
    const std::size_t end = text_.find_first_of("\"\\", at_);
    if (end == std::string_view::npos || text_[end] == '\\') return false;
    value = text_.substr(at_, end - at_);
    at_ = end + 1;
    return true;
  }

  bool object(const TypeInfo& type, std::byte* p, const std::string& prefix, bool top);
  bool field(const FieldInfo& f, std::byte* p, const std::string& path);
  bool element(const FieldInfo& f, std::byte* p, const std::string& path);
  template <class I>
  bool integer(std::byte* p, const std::string& path);
  template <class F>
  bool floating(std::byte* p, const std::string& path);
  bool base64(const std::string& path);
  std::string_view number_token();

  std::string_view text_;
  std::uint8_t* bulk_;
  std::uint32_t capacity_;
  std::uint32_t bulk_bytes_ = 0;
  std::size_t at_ = 0;
  JsonError error_;
};

std::string names_of(const TypeInfo& type, bool top) {
  std::string names;
  for (const FieldInfo& f : type.fields) names += (names.empty() ? "" : ", ") + std::string(f.name);
  if (top && type.has_bulk()) names += ", " + std::string(type.bulk_name);
  return names;
}

bool Parser::object(const TypeInfo& type, std::byte* p, const std::string& prefix, bool top) {
  const std::string path = prefix.empty() ? "" : prefix.substr(0, prefix.size() - 1);
  if (!expect('{', path)) return false;
  if (accept('}')) return true;
  std::vector<bool> seen(type.fields.size() + 1);
  do {
    skip_space();
    const std::size_t start = at_;
    std::string_view name;
    if (!string(name)) {
      at_ = start;
      return fail(path, found(), "a field's name in quotes");
    }
    std::size_t i = 0;
    while (i < type.fields.size() && type.fields[i].name != name) ++i;
    const bool is_bulk = i == type.fields.size() && top && type.has_bulk() && name == type.bulk_name;
    if (i == type.fields.size() && !is_bulk) {
      at_ = start;
      return fail(prefix + std::string(name), "no such field", names_of(type, top));
    }
    if (seen[i]) {
      at_ = start;
      return fail(prefix + std::string(name), "given twice", "once");
    }
    seen[i] = true;
    const std::string inner = prefix + std::string(name);
    if (!expect(':', inner)) return false;
    if (is_bulk ? !base64(inner) : !field(type.fields[i], p + type.fields[i].offset, inner)) return false;
  } while (accept(','));
  return expect('}', path);
}

bool Parser::field(const FieldInfo& f, std::byte* p, const std::string& path) {
  if (!f.is_array) return element(f, p, path);
  const std::string wanted = "[...] of " + std::to_string(f.count);
  if (!accept('[')) return fail(path, found(), wanted);
  const std::uint32_t step = f.kind == Kind::nested ? f.nested->size : size_of(f.kind);
  for (std::uint32_t i = 0; i < f.count; ++i) {
    if (i > 0 && !accept(',')) return fail(path, std::to_string(i) + " elements", wanted);
    if (!element(f, p + i * step, path + "[" + std::to_string(i) + "]")) return false;
  }
  return accept(']') || fail(path, "more elements", wanted);
}

bool Parser::element(const FieldInfo& f, std::byte* p, const std::string& path) {
  switch (f.kind) {
    case Kind::i8:
      return integer<std::int8_t>(p, path);
    case Kind::u8:
      return integer<std::uint8_t>(p, path);
    case Kind::i16:
      return integer<std::int16_t>(p, path);
    case Kind::u16:
      return integer<std::uint16_t>(p, path);
    case Kind::i32:
      return integer<std::int32_t>(p, path);
    case Kind::u32:
      return integer<std::uint32_t>(p, path);
    case Kind::i64:
      return integer<std::int64_t>(p, path);
    case Kind::u64:
      return integer<std::uint64_t>(p, path);
    case Kind::f32:
      return floating<float>(p, path);
    case Kind::f64:
      return floating<double>(p, path);
    case Kind::nested:
      return object(*f.nested, p, path + ".", false);
  }
  return false;
}

/// The number that starts here, by JSON's grammar; empty when none does.
std::string_view Parser::number_token() {
  skip_space();
  std::size_t i = at_;
  const auto digits = [&] {
    const std::size_t first = i;
    while (i < text_.size() && text_[i] >= '0' && text_[i] <= '9') ++i;
    return i - first;
  };
  if (i < text_.size() && text_[i] == '-') ++i;
  const std::size_t whole = i, n = digits();
  if (n == 0 || (n > 1 && text_[whole] == '0')) return {};
  if (i < text_.size() && text_[i] == '.' && (++i, digits() == 0)) return {};
  if (i < text_.size() && (text_[i] == 'e' || text_[i] == 'E')) {
    ++i;
    if (i < text_.size() && (text_[i] == '+' || text_[i] == '-')) ++i;
    if (digits() == 0) return {};
  }
  return text_.substr(at_, i - at_);
}

template <class I>
bool Parser::integer(std::byte* p, const std::string& path) {
  const std::string_view token = number_token();
  I value{};
  const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), value);
  if (token.empty() || error != std::errc{} || end != token.data() + token.size())
    return fail(path, found(),
                "an integer from " + std::to_string(std::numeric_limits<I>::min()) + " to " +
                    std::to_string(std::numeric_limits<I>::max()));
  at_ += token.size();
  std::memcpy(p, &value, sizeof value);
  return true;
}

/// The NaN of canonicalise(); the C++ library's NaN is another one on MIPS.
template <class F>
constexpr F the_one_nan() {
  if constexpr (sizeof(F) == 4)
    return std::bit_cast<F>(std::uint32_t{0x7fc00000});
  else
    return std::bit_cast<F>(std::uint64_t{0x7ff8000000000000});
}

template <class F>
bool Parser::floating(std::byte* p, const std::string& path) {
  const std::string allowed = "a number, \"NaN\", \"Infinity\" or \"-Infinity\"";
  const std::string_view token = number_token();
  F value{};
  if (token.empty()) {
    const std::size_t start = at_;
    std::string_view name;
    if (string(name) && name == "NaN")
      value = the_one_nan<F>();
    else if (name == "Infinity")
      value = std::numeric_limits<F>::infinity();
    else if (name == "-Infinity")
      value = -std::numeric_limits<F>::infinity();
    else {
      at_ = start;
      return fail(path, found(), allowed);
    }
  } else {
    const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), value);
    if (error != std::errc{} || end != token.data() + token.size())
      return fail(path, std::string(token),
                  sizeof(F) == 4 ? "a number in the range of a float" : "a number in the range of a double");
    at_ += token.size();
  }
  std::memcpy(p, &value, sizeof value);
  return true;
}

bool Parser::base64(const std::string& path) {
  const auto digit = [](char c) -> int {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    return c == '+' ? 62 : c == '/' ? 63 : -1;
  };
  skip_space();
  const std::size_t start = at_;
  const std::string allowed = "base64, padded, of at most " + std::to_string(capacity_) + " bytes";
  std::string_view s;
  if (!string(s) || s.size() % 4 != 0) {
    at_ = start;
    return fail(path, found(), allowed);
  }
  std::size_t n = s.size() / 4 * 3;
  for (int i = 0; i < 2 && !s.empty() && s.back() == '='; ++i) s.remove_suffix(1), --n;
  if (n > capacity_) {
    at_ = start;
    return fail(path, std::to_string(n) + " bytes", allowed);
  }
  std::uint32_t group = 0, bits = 0, used = 0;
  for (const char c : s) {
    const int d = digit(c);
    if (d < 0) {
      at_ = start;
      return fail(path, "'" + std::string(1, c) + "' in base64", allowed);
    }
    group = group << 6 | static_cast<std::uint32_t>(d);
    bits += 6;
    if (bits >= 8) {
      bits -= 8;
      bulk_[used++] = static_cast<std::uint8_t>(group >> bits);
    }
  }
  bulk_bytes_ = used;
  return true;
}

}  // namespace

std::optional<JsonError> from_json(const TypeInfo& type, std::string_view json, void* message,
                                   std::uint32_t bulk_capacity) {
  const auto defaults = [&] {
    type.reset(message);
    if (type.has_bulk()) type.set_bulk_capacity(message, bulk_capacity);
  };
  defaults();
  Parser parser(json, static_cast<std::uint8_t*>(message) + type.size, type.has_bulk() ? bulk_capacity : 0);
  if (!parser.message(type, static_cast<std::byte*>(message))) {
    defaults();
    return parser.take_error();
  }
  if (type.has_bulk()) {
    type.set_bulk_capacity(message, bulk_capacity);
    const std::uint32_t wanted = type.bulk_used(message);
    if (parser.bulk_bytes() != wanted) {
      defaults();
      return JsonError{json.size(), std::string(type.bulk_name), std::to_string(parser.bulk_bytes()) + " bytes",
                       std::to_string(wanted) + ", as the other fields say"};
    }
  }
  return std::nullopt;
}

}  // namespace sinew::msg
