#include "record/run/ros2_json.hpp"

#include <array>

#include "math/hash.hpp"
#include "msg/text.hpp"
#include "record/run/cdr_stream.hpp"

namespace sinew::record {
namespace {

using Kind = Ros2Field::Kind;
using Shape = Ros2Field::Shape;

bool is_utf8(std::string_view text) {
  int follow = 0;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (follow > 0) {
      if ((byte & 0xC0) != 0x80) return false;
      --follow;
    } else if (byte >= 0x80) {
      if (byte < 0xC2 || byte > 0xF4) return false;
      follow = byte >= 0xF0 ? 3 : byte >= 0xE0 ? 2 : 1;
    }
  }
  return follow == 0;
}

/// Bytes that are not UTF-8 are shown one by one.
void append_quoted(std::string_view text, std::string& out) {
  constexpr char kHex[] = "0123456789abcdef";
  const bool utf8 = is_utf8(text);
  out += '"';
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7F || (byte >= 0x80 && !utf8)) {
      out += "\\u00";
      out += kHex[byte >> 4];
      out += kHex[byte & 15];
      continue;
    }
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  out += '"';
}

class ToJson {
 public:
  ToJson(const Ros2Schema& schema, std::span<const std::byte> cdr, std::string& out)
      : schema_(schema), from_(cdr), out_(out) {}

  bool run() {
    object(schema_.root());
    return from_.at_end();
  }

 private:
  void object(const Ros2Schema::Type& type) {
    out_ += '{';
    for (const Ros2Field& f : type.fields) {
      if (!from_.good()) return;
      if (&f != type.fields.data()) out_ += ',';
      append_quoted(f.name, out_);
      out_ += ':';
      field(f);
    }
    if (type.fields.empty()) from_.number<std::uint8_t>();  // a struct has at least one member
    out_ += '}';
  }

  void field(const Ros2Field& f) {
    if (f.shape == Shape::one) return element(f);
    const std::uint32_t count = f.shape == Shape::array ? f.count : from_.length(1);
    if (f.shape == Shape::sequence && f.kind == Kind::u8) return bulk(count);
    out_ += '[';
    for (std::uint32_t i = 0; i < count && from_.good(); ++i) {
      if (i > 0) out_ += ',';
      element(f);
    }
    out_ += ']';
  }

  void element(const Ros2Field& f) {
    switch (f.kind) {
      case Kind::boolean:
        out_ += from_.boolean() ? "true" : "false";
        return;
      case Kind::i8:
        return number<std::int8_t>(msg::Kind::i8);
      case Kind::u8:
        return number<std::uint8_t>(msg::Kind::u8);
      case Kind::i16:
        return number<std::int16_t>(msg::Kind::i16);
      case Kind::u16:
        return number<std::uint16_t>(msg::Kind::u16);
      case Kind::i32:
        return number<std::int32_t>(msg::Kind::i32);
      case Kind::u32:
        return number<std::uint32_t>(msg::Kind::u32);
      case Kind::i64:
        return number<std::int64_t>(msg::Kind::i64);
      case Kind::u64:
        return number<std::uint64_t>(msg::Kind::u64);
      case Kind::f32:
        return number<std::uint32_t>(msg::Kind::f32);  // its bits
      case Kind::f64:
        return number<std::uint64_t>(msg::Kind::f64);
      case Kind::text:
        return append_quoted(from_.text(), out_);
      case Kind::nested:
        return object(schema_.type(f));
    }
  }

  template <class T>
  void number(msg::Kind kind) {
    const T value = from_.number<T>();
    const std::size_t start = out_.size();
    msg::append_number(kind, &value, out_);
    if (const char last = out_.back(); last == 'N' || last == 'y') {  // NaN, Infinity
      out_.insert(start, 1, '"');
      out_ += '"';
    }
  }

  void bulk(std::uint32_t size) {
    const auto bytes = from_.bytes(size);
    const std::uint64_t hash = math::hash64(bytes.data(), bytes.size());
    std::array<std::uint8_t, 8> digits;
    for (unsigned i = 0; i < 8; ++i) digits[i] = static_cast<std::uint8_t>(hash >> (56 - 8 * i));
    out_ += "{\"bytes\":" + std::to_string(bytes.size()) + ",\"hash\":\"";
    msg::append_hex(digits, out_);
    out_ += "\"}";
  }

  const Ros2Schema& schema_;
  CdrReader from_;
  std::string& out_;
};

}  // namespace

bool to_json(const Ros2Schema& schema, std::span<const std::byte> cdr, std::string& out) {
  const std::size_t before = out.size();
  if (ToJson(schema, cdr, out).run()) return true;
  out.resize(before);
  return false;
}

}  // namespace sinew::record
