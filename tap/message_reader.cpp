#include "tap/message_reader.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "hal/did_you_mean.hpp"
#include "msg/text.hpp"

namespace sinew::tap {
namespace {

using Json = nlohmann::ordered_json;
using msg::FieldInfo;
using msg::Kind;
using msg::TypeInfo;

/// As msg::canonicalise() has it: the C++ library's own is another one on MIPS.
template <class F>
constexpr F the_one_nan() {
  if constexpr (sizeof(F) == 4)
    return std::bit_cast<F>(std::uint32_t{0x7fc00000});
  else
    return std::bit_cast<F>(std::uint64_t{0x7ff8000000000000});
}

// What rounds to infinity: half a step above the largest float, whose own shortest text, 3.4028235e+38, is above it,
// too.
constexpr double kBeyondFloat = 0x1.ffffffp127;

std::string names_of(const TypeInfo& type) {
  std::string names;
  for (const FieldInfo& f : type.fields) names += (names.empty() ? "" : ", ") + std::string(f.name);
  return names;
}

/// The type says what is looked at, so the depth is that of the type.
class MessageReader {
 public:
  bool object(const TypeInfo& type, const Json& json, std::byte* p, const std::string& path) {
    if (!json.is_object()) return fail(path, found(json), "{...}");
    for (const auto& [name, value] : json.items()) {
      const std::string inner = path.empty() ? name : path + "." + name;
      const FieldInfo* field = nullptr;
      for (const FieldInfo& f : type.fields)
        if (f.name == name) field = &f;
      if (!field) return fail(inner, "no such field", names_of(type));
      if (!read(*field, value, p + field->offset, inner)) return false;
    }
    return true;
  }
  std::string take_wrong() { return std::move(wrong_); }

 private:
  bool fail(const std::string& path, const std::string& what, const std::string& allowed) {
    wrong_ = (path.empty() ? "" : path + ": ") + what + ": " + allowed;
    return false;
  }

  static std::string found(const Json& json) {
    std::string text = json.dump(-1, ' ', true, Json::error_handler_t::replace);
    if (text.size() > 24) text = text.substr(0, 21) + "...";
    return text;
  }

  bool read(const FieldInfo& f, const Json& json, std::byte* p, const std::string& path) {
    if (!f.is_array) return element(f, json, p, path);
    const std::string wanted = "[...] of " + std::to_string(f.count);
    if (!json.is_array()) return fail(path, found(json), wanted);
    if (json.size() != f.count) return fail(path, std::to_string(json.size()) + " elements", wanted);
    const std::uint32_t step = f.kind == Kind::nested ? f.nested->size : msg::size_of(f.kind);
    for (std::uint32_t i = 0; i < f.count; ++i)
      if (!element(f, json[i], p + std::size_t{i} * step, path + "[" + std::to_string(i) + "]")) return false;
    return true;
  }

  /// The number of "armed", or of "lease, limit" where names are of bits.
  static std::optional<std::uint32_t> number_of(const FieldInfo& f, std::string_view text) {
    std::uint32_t number = 0;
    if (f.bits && text == "none") return number;
    while (true) {
      const auto end = f.bits ? std::min(text.find(", "), text.size()) : text.size();
      const auto known = std::find_if(f.names.begin(), f.names.end(),
                                      [&](const msg::ValueName& n) { return n.name == text.substr(0, end); });
      if (known == f.names.end()) return std::nullopt;
      number |= known->value;
      if (end == text.size()) return number;
      text.remove_prefix(end + 2);
    }
  }

  bool element(const FieldInfo& f, const Json& json, std::byte* p, const std::string& path) {
    if (f.names.empty() || !json.is_string()) return number(f, json, p, path);
    if (const auto named = number_of(f, json.get_ref<const std::string&>())) return number(f, Json(*named), p, path);
    std::string wanted;
    std::vector<std::string> names;
    for (const msg::ValueName& known : f.names) {
      wanted += (wanted.empty() ? "" : ", ") + std::string(known.name);
      names.emplace_back(known.name);
    }
    const std::string hint = f.bits ? "" : hal::did_you_mean(json.get_ref<const std::string&>(), names);
    return fail(path, found(json), (f.bits ? "some of " : "one of ") + wanted + hint);
  }

  bool number(const FieldInfo& f, const Json& json, std::byte* p, const std::string& path) {
    switch (f.kind) {
      case Kind::i8:
        return integer<std::int8_t>(json, p, path);
      case Kind::u8:
        return integer<std::uint8_t>(json, p, path);
      case Kind::i16:
        return integer<std::int16_t>(json, p, path);
      case Kind::u16:
        return integer<std::uint16_t>(json, p, path);
      case Kind::i32:
        return integer<std::int32_t>(json, p, path);
      case Kind::u32:
        return integer<std::uint32_t>(json, p, path);
      case Kind::i64:
        return integer<std::int64_t>(json, p, path);
      case Kind::u64:
        return integer<std::uint64_t>(json, p, path);
      case Kind::f32:
        return real<float>(json, p, path);
      case Kind::f64:
        return real<double>(json, p, path);
      case Kind::nested:
        return object(*f.nested, json, p, path);
    }
    return false;
  }

  template <class I>
  bool integer(const Json& json, std::byte* p, const std::string& path) {
    I value{};
    bool fits = false;
    if (json.is_number_unsigned()) {
      const auto number = json.get<std::uint64_t>();
      fits = std::in_range<I>(number), value = static_cast<I>(number);
    } else if (json.is_number_integer()) {
      const auto number = json.get<std::int64_t>();
      fits = std::in_range<I>(number), value = static_cast<I>(number);
    }
    if (!fits)
      return fail(path, found(json),
                  "an integer from " + std::to_string(std::numeric_limits<I>::min()) + " to " +
                      std::to_string(std::numeric_limits<I>::max()));
    std::memcpy(p, &value, sizeof value);
    return true;
  }

  template <class F>
  bool real(const Json& json, std::byte* p, const std::string& path) {
    F value{};
    if (json.is_number()) {
      const auto number = json.get<double>();
      constexpr double kMost = std::numeric_limits<F>::max();
      if (sizeof(F) == 4 && std::fabs(number) >= kBeyondFloat)
        return fail(path, found(json), "a number in the range of a float");
      value = static_cast<F>(std::clamp(number, -kMost, kMost));
    } else if (json == "NaN") {
      value = the_one_nan<F>();
    } else if (json == "Infinity") {
      value = std::numeric_limits<F>::infinity();
    } else if (json == "-Infinity") {
      value = -std::numeric_limits<F>::infinity();
    } else {
      return fail(path, found(json), "a number, \"NaN\", \"Infinity\" or \"-Infinity\"");
    }
    std::memcpy(p, &value, sizeof value);
    return true;
  }

  std::string wrong_;
};

}  // namespace

std::optional<std::string> read_message(const TypeInfo& type, const Json& object, void* message) {
  type.reset(message);
  MessageReader reader;
  if (reader.object(type, object, static_cast<std::byte*>(message), "")) return std::nullopt;
  type.reset(message);
  return reader.take_wrong();
}

}  // namespace sinew::tap
