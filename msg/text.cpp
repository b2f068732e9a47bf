#include "msg/text.hpp"

#include <charconv>
#include <cmath>
#include <cstring>

namespace sinew::msg {
namespace {

template <class T>
T read(const void* p) {
  T v;
  std::memcpy(&v, p, sizeof v);
  return v;
}

template <class I>
void append_integer(I v, std::string& out) {
  char buffer[24];
  out.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, v).ptr);
}

template <class F>
void append_float(F v, std::string& out) {
  if (v != v) {
    out += "NaN";
  } else if (std::isinf(v)) {
    out += v > 0 ? "Infinity" : "-Infinity";
  } else {
    char buffer[40];
    const std::string_view digits(buffer, std::size_t(std::to_chars(buffer, buffer + sizeof buffer, v).ptr - buffer));
    out += digits;
    if (digits.find_first_of(".e") == digits.npos) out += ".0";
  }
}

}  // namespace

std::string remark_of(const FieldInfo& field) {
  std::string text;
  for (const ValueName& known : field.names) {
    text += text.empty() ? (field.bits ? "bits: " : "") : ", ";
    text += std::to_string(known.value) + " " + std::string(known.name);
  }
  if (!text.empty() && !field.doc.empty()) text += "; ";
  return text += field.doc;
}

void append_number(Kind kind, const void* p, std::string& out) {
  switch (kind) {
    case Kind::i8:
      return append_integer(int{read<std::int8_t>(p)}, out);
    case Kind::u8:
      return append_integer(unsigned{read<std::uint8_t>(p)}, out);
    case Kind::i16:
      return append_integer(int{read<std::int16_t>(p)}, out);
    case Kind::u16:
      return append_integer(unsigned{read<std::uint16_t>(p)}, out);
    case Kind::i32:
      return append_integer(read<std::int32_t>(p), out);
    case Kind::u32:
      return append_integer(read<std::uint32_t>(p), out);
    case Kind::i64:
      return append_integer(read<std::int64_t>(p), out);
    case Kind::u64:
      return append_integer(read<std::uint64_t>(p), out);
    case Kind::f32:
      return append_float(read<float>(p), out);
    case Kind::f64:
      return append_float(read<double>(p), out);
    case Kind::nested:
      return;
  }
}

void append_hex(std::span<const std::uint8_t> bytes, std::string& out) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  for (const std::uint8_t b : bytes) out += kDigits[b >> 4], out += kDigits[b & 15];
}

void append_base64(std::span<const std::uint8_t> bytes, std::string& out) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t n = bytes.size() - i < 3 ? bytes.size() - i : 3;
    std::uint32_t group = std::uint32_t{bytes[i]} << 16;
    if (n > 1) group |= std::uint32_t{bytes[i + 1]} << 8;
    if (n > 2) group |= bytes[i + 2];
    for (std::size_t c = 0; c < 4; ++c) out += c <= n ? kDigits[group >> (18 - 6 * c) & 63] : '=';
  }
}

}  // namespace sinew::msg
