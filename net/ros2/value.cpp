#include "net/ros2/value.hpp"

#include <charconv>
#include <cstring>

namespace sinew::ros2 {
namespace {

constexpr std::size_t kHead = 4;

bool is_bytes(const Field& f) { return f.shape != Shape::one && (f.kind == Kind::u8 || f.kind == Kind::i8); }

class Writer {
 public:
  explicit Writer(std::vector<std::uint8_t>& out) : out_(out) { out_.assign({0, 1, 0, 0}); }

  void type(const Type& type, const Value& value) {
    for (std::size_t i = 0; i < type.fields.size(); ++i) field(type.fields[i], value.items[i]);
  }

 private:
  void field(const Field& f, const Value& value) {
    if (is_bytes(f)) return bytes(f, value);
    if (f.shape == Shape::one) return element(f, value);
    if (f.shape == Shape::sequence) number(value.items.size(), 4);
    for (const Value& item : value.items) element(f, item);
  }
  void bytes(const Field& f, const Value& value) {
    const std::size_t size = value.bytes.size();
    if (f.shape == Shape::sequence) number(size, 4);
    if (f.shape == Shape::fixed && size != f.count)
      out_.resize(out_.size() + f.count);  // not set: zeros
    else
      out_.insert(out_.end(), value.bytes.begin(), value.bytes.end());
  }
  void element(const Field& f, const Value& value) {
    if (f.kind == Kind::nested) return type(*f.nested, value);
    if (f.kind == Kind::text) return text(f, value.text);
    if (f.kind == Kind::f32) return number(std::bit_cast<std::uint32_t>(static_cast<float>(value.number())), 4);
    if (f.kind == Kind::boolean) return number(value.bits != 0 ? 1 : 0, 1);
    number(value.bits, size_of(f.kind));
  }
  void text(const Field& f, std::string_view text) {
    if (f.longest_text != 0) text = text.substr(0, f.longest_text);
    number(text.size() + 1, 4);
    out_.insert(out_.end(), text.begin(), text.end());
    out_.push_back(0);
  }
  void number(std::uint64_t bits, std::uint32_t size) {
    const std::size_t at = out_.size() - kHead;
    const std::size_t gap = (size - at % size) % size;
    out_.resize(out_.size() + gap + size);
    std::uint8_t* const p = out_.data() + out_.size() - size;
    for (std::uint32_t i = 0; i < size; ++i) p[i] = static_cast<std::uint8_t>(bits >> (8 * i));
  }

  std::vector<std::uint8_t>& out_;
};

class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> in) : in_(in) {}

  Decoded read(const Type& whole, Value& value) {
    if (in_.size() < kHead || in_[0] != 0 || in_[1] > 1) return {"not XCDR1 (00 00 or 00 01)", 0};
    big_ = in_[1] == 0;
    at_ = kHead;
    type(whole, value);
    if (!error_ && in_.size() - at_ > 3) error_ = "bytes left over behind the message";
    return {error_, at_};
  }

 private:
  bool fail(const char* error) {
    if (!error_) error_ = error;
    return false;
  }
  bool type(const Type& type, Value& value) {
    if (value.items.size() != type.fields.size()) Message::make_default(type, value);
    for (std::size_t i = 0; i < type.fields.size(); ++i)
      if (!field(type.fields[i], value.items[i])) return false;
    return true;
  }
  bool field(const Field& f, Value& value) {
    if (f.shape == Shape::one) return element(f, value);
    std::uint64_t count = f.count;
    if (f.shape == Shape::sequence) {
      if (!number(count, 4)) return false;
      if (f.count != 0 && count > f.count) return fail("a sequence longer than its bound");
    }
    const std::uint64_t each = least_bytes(f);
    if (count * each > in_.size() - at_) return fail("input ends inside the message");
    if (is_bytes(f)) {
      value.bytes = in_.subspan(at_, static_cast<std::size_t>(count));
      at_ += static_cast<std::size_t>(count);
      return true;
    }
    values_ += static_cast<std::size_t>(count);
    if (values_ > kMostValues) return fail("more elements than a message may have");
    value.items.resize(static_cast<std::size_t>(count));
    for (Value& item : value.items)
      if (!element(f, item)) return false;
    return true;
  }
  /// At least 1, so that lengths are bounded by the input.
  static std::uint64_t least_bytes(const Field& f) {
    const std::uint32_t bytes = f.kind == Kind::nested ? f.nested->least_bytes
                                : f.kind == Kind::text ? 4
                                                       : size_of(f.kind);
    return bytes == 0 ? 1 : bytes;
  }
  bool element(const Field& f, Value& value) {
    if (f.kind == Kind::nested) return type(*f.nested, value);
    if (f.kind == Kind::text) return text(f, value.text);
    if (!number(value.bits, size_of(f.kind))) return false;
    switch (f.kind) {
      case Kind::boolean:
        if (value.bits > 1) return fail("a bool other than 0 and 1");
        break;
      case Kind::i8:
        value.set_integer(static_cast<std::int8_t>(value.bits));
        break;
      case Kind::i16:
        value.set_integer(static_cast<std::int16_t>(value.bits));
        break;
      case Kind::i32:
        value.set_integer(static_cast<std::int32_t>(value.bits));
        break;
      case Kind::f32:
        value.set(static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(value.bits))));
        break;
      default:
        break;
    }
    return true;
  }
  bool text(const Field& f, std::string& text) {
    std::uint64_t size = 0;
    if (!number(size, 4)) return false;
    if (size > in_.size() - at_) return fail("input ends inside the message");
    text.clear();
    if (size == 0) return true;  // some peers send an empty text so
    const auto bytes = in_.subspan(at_, static_cast<std::size_t>(size));
    if (bytes.back() != 0) return fail("a text without its 0");
    if (std::memchr(bytes.data(), 0, bytes.size() - 1) != nullptr) return fail("a text with a 0 inside");
    if (f.longest_text != 0 && size - 1 > f.longest_text) return fail("a text longer than its bound");
    text.assign(bytes.begin(), bytes.end() - 1);
    at_ += static_cast<std::size_t>(size);
    return true;
  }
  bool number(std::uint64_t& bits, std::uint32_t size) {
    const std::size_t gap = (size - (at_ - kHead) % size) % size;
    if (in_.size() - at_ < gap + size) return fail("input ends inside the message");
    at_ += gap;
    bits = 0;
    for (std::uint32_t i = 0; i < size; ++i) bits |= std::uint64_t{in_[at_ + i]} << (8 * (big_ ? size - 1 - i : i));
    at_ += size;
    return true;
  }

  std::span<const std::uint8_t> in_;
  std::size_t at_ = 0, values_ = 0;
  bool big_ = false;
  const char* error_ = nullptr;
};

}  // namespace

Message::Message(const Type& type) : type_(type) { make_default(type, root_); }

void Message::make_default(const Type& type, Value& value) {
  value.items.resize(type.fields.size());
  for (std::size_t i = 0; i < type.fields.size(); ++i) make_default(type.fields[i], value.items[i]);
}

void Message::make_default(const Field& field, Value& value) {
  value = Value();
  if (field.shape == Shape::sequence || is_bytes(field)) return;
  if (field.shape == Shape::fixed) value.items.resize(field.count);
  if (field.kind != Kind::nested) return;
  if (field.shape == Shape::one) return make_default(*field.nested, value);
  for (Value& item : value.items) make_default(*field.nested, item);
}

Value* Message::find(std::string_view path) { return find_value(type_, root_, path); }

Value* find_value(const Type& type, Value& value, std::string_view path, const Field** field) {
  const auto dot = path.find('.');
  std::string_view step = path.substr(0, dot);
  const auto open = step.find('[');
  const std::string_view name = step.substr(0, open);
  for (std::size_t i = 0; i < type.fields.size(); ++i) {
    const Field& f = type.fields[i];
    if (f.name != name) continue;
    Value* found = &value.items[i];
    if (open != step.npos) {
      std::size_t index = 0;
      const auto [end, error] = std::from_chars(step.data() + open + 1, step.data() + step.size(), index);
      if (error != std::errc{} || std::string_view(end, std::size_t(step.data() + step.size() - end)) != "]")
        return nullptr;
      if (index >= found->items.size()) return nullptr;
      found = &found->items[index];
    }
    if (field) *field = &f;
    if (dot == path.npos) return found;
    const bool is_element = f.shape == Shape::one || open != step.npos;
    return f.nested && is_element ? find_value(*f.nested, *found, path.substr(dot + 1), field) : nullptr;
  }
  return nullptr;
}

void encode(const Type& type, const Value& value, std::vector<std::uint8_t>& out) { Writer(out).type(type, value); }

Decoded decode(const Type& type, std::span<const std::uint8_t> in, Value& value) {
  return Reader(in).read(type, value);
}

}  // namespace sinew::ros2
