#include "rt/failsafe.hpp"

#include <algorithm>
#include <charconv>
#include <cstring>

#include "math/convert.hpp"
#include "math/elementary.hpp"
#include "msg/text.hpp"

namespace sinew::rt {
namespace {

template <class V>
double read_as(const std::byte* at) {
  V v;
  std::memcpy(&v, at, sizeof v);
  return static_cast<double>(v);
}

template <class V>
void write_as(std::byte* at, double value) {
  V v;
  if constexpr (std::is_integral_v<V>)
    v = math::to_integer<V>(value);
  else
    v = static_cast<V>(value);
  std::memcpy(at, &v, sizeof v);
}

/// The index behind a name, if there is one: "value[2]" is 2. False: not an index.
bool take_index(std::string_view& name, std::uint32_t& index) {
  const std::size_t open = name.find('[');
  if (open == std::string_view::npos) return true;
  if (name.back() != ']') return false;
  const char* const first = name.data() + open + 1;
  const char* const last = name.data() + name.size() - 1;
  const auto [end, error] = std::from_chars(first, last, index);
  name = name.substr(0, open);
  return error == std::errc() && end == last;
}

}  // namespace

double NumberField::read(const void* message) const {
  const std::byte* at = static_cast<const std::byte*>(message) + offset;
  switch (kind) {
    case msg::Kind::i8:
      return read_as<std::int8_t>(at);
    case msg::Kind::u8:
      return read_as<std::uint8_t>(at);
    case msg::Kind::i16:
      return read_as<std::int16_t>(at);
    case msg::Kind::u16:
      return read_as<std::uint16_t>(at);
    case msg::Kind::i32:
      return read_as<std::int32_t>(at);
    case msg::Kind::u32:
      return read_as<std::uint32_t>(at);
    case msg::Kind::i64:
      return read_as<std::int64_t>(at);
    case msg::Kind::u64:
      return read_as<std::uint64_t>(at);
    case msg::Kind::f32:
      return read_as<float>(at);
    default:
      return read_as<double>(at);
  }
}

void NumberField::write(void* message, double value) const {
  std::byte* at = static_cast<std::byte*>(message) + offset;
  switch (kind) {
    case msg::Kind::i8:
      return write_as<std::int8_t>(at, value);
    case msg::Kind::u8:
      return write_as<std::uint8_t>(at, value);
    case msg::Kind::i16:
      return write_as<std::int16_t>(at, value);
    case msg::Kind::u16:
      return write_as<std::uint16_t>(at, value);
    case msg::Kind::i32:
      return write_as<std::int32_t>(at, value);
    case msg::Kind::u32:
      return write_as<std::uint32_t>(at, value);
    case msg::Kind::i64:
      return write_as<std::int64_t>(at, value);
    case msg::Kind::u64:
      return write_as<std::uint64_t>(at, value);
    case msg::Kind::f32:
      return write_as<float>(at, value);
    default:
      return write_as<double>(at, value);
  }
}

std::optional<NumberField> find_number(const msg::TypeInfo& type, std::string_view path) {
  const std::size_t dot = path.find('.');
  std::string_view name = path.substr(0, dot);
  std::uint32_t index = 0;
  const bool indexed = name.find('[') != std::string_view::npos;
  if (!take_index(name, index)) return std::nullopt;
  for (const msg::FieldInfo& f : type.fields) {
    if (f.name != name || f.is_array != indexed || index >= f.count) continue;
    const std::uint32_t offset = f.offset + index * (f.nested ? f.nested->size : msg::size_of(f.kind));
    if (!f.nested) return dot == path.npos ? std::optional(NumberField{offset, f.kind}) : std::nullopt;
    auto inner = dot == path.npos ? std::nullopt : find_number(*f.nested, path.substr(dot + 1));
    if (inner) inner->offset += offset;
    return inner;
  }
  return std::nullopt;
}

std::uint32_t NumberFields::size(const void* message) const {
  if (!count) return most;
  const double used = count->read(message);
  return used > 0 ? static_cast<std::uint32_t>(std::min<double>(used, most)) : 0;  // NaN: none
}

double NumberFields::read(const void* message, std::uint32_t i) const {
  return first.read(static_cast<const std::byte*>(message) + std::size_t{i} * stride);
}

std::optional<NumberFields> find_numbers(const msg::TypeInfo& type, std::string_view path) {
  const std::size_t open = path.find("[*]");
  if (open == path.npos) {
    const auto one = find_number(type, path);
    return one ? std::optional(NumberFields{*one}) : std::nullopt;
  }
  const std::string_view name = path.substr(0, open);
  for (const msg::FieldInfo& f : type.fields) {
    if (f.name != name || !f.is_array) continue;
    const auto first = find_number(type, std::string(name) + "[0]" + std::string(path.substr(open + 3)));
    if (!first) return std::nullopt;
    return NumberFields{*first, static_cast<std::uint32_t>(f.nested ? f.nested->size : msg::size_of(f.kind)),
                        static_cast<std::uint32_t>(f.count), find_number(type, "count")};
  }
  return std::nullopt;
}

std::vector<std::string> number_paths(const msg::TypeInfo& type) {
  std::vector<std::string> paths;
  for (const msg::FieldInfo& f : type.fields) {
    const std::string name = std::string(f.name) + (f.is_array ? "[0]" : "");
    if (f.nested)
      for (const std::string& inner : number_paths(*f.nested)) paths.push_back(name + "." + inner);
    else
      paths.push_back(name);
  }
  return paths;
}

void Failsafe::declare(Declaration& d) {
  d.in(port_name(spec_), port_, {.supervises = true});
  if (spec_.kind == FailsafeSpec::Kind::stuck) d.state(any_, sequence_, since_, before_);
  if (spec_.kind == FailsafeSpec::Kind::value) d.state(any_, sequence_, since_, bad_, measured_);
}

void Failsafe::configure() {
  const msg::TypeInfo& type = *port_.type();
  before_.assign(type.size, std::byte{});
  for (const msg::FieldInfo& f : type.fields)
    if (f.name == "stamp") stamp_offset_ = f.offset;
  if (spec_.kind == FailsafeSpec::Kind::value) field_ = *find_numbers(type, spec_.field.value);  // the check found it
}

void Failsafe::reset() {
  any_ = bad_ = false;
  measured_ = 0;
}

bool Failsafe::look(Time now) noexcept {
  if (port_.size() == 0) {
    measured_ = math::kNan;
    return true;
  }
  switch (spec_.kind) {
    case FailsafeSpec::Kind::silent:
      return look_silent(now);
    case FailsafeSpec::Kind::stuck:
      return look_stuck();
    case FailsafeSpec::Kind::value:
      return look_value(now);
  }
  return true;
}

bool Failsafe::look_silent(Time now) noexcept {
  const Duration age = now - port_.header(0)->published;
  measured_ = msg::seconds(age);
  return age >= spec_.time;
}

bool Failsafe::is_new() noexcept {
  const std::uint32_t sequence = port_.header(0)->sequence;
  const bool is = !any_ || sequence != sequence_;
  any_ = true;
  sequence_ = sequence;
  return is;
}

bool Failsafe::same_as_before(const void* message) const noexcept {
  const auto* bytes = static_cast<const std::byte*>(message);
  const std::size_t after = stamp_offset_ + sizeof(Time);
  return std::memcmp(bytes, before_.data(), stamp_offset_) == 0 &&
         std::memcmp(bytes + after, before_.data() + after, before_.size() - after) == 0;
}

bool Failsafe::look_stuck() noexcept {
  const Time published = port_.header(0)->published;
  const bool first = !any_;
  if (is_new() && (first || !same_as_before(port_.get()))) {
    std::memcpy(before_.data(), port_.get(), before_.size());
    since_ = published;
  }
  measured_ = msg::seconds(published - since_);
  return published - since_ >= spec_.time;
}

/// How far within the limits; negative: beyond one.
double Failsafe::margin(double value) const noexcept {
  return std::min(spec_.below ? value - *spec_.below : math::kInf, spec_.above ? *spec_.above - value : math::kInf);
}

/// The number that is least within the limits, or beyond them; NaN without any.
double Failsafe::worst_of(const void* message) const noexcept {
  double worst = math::kNan;
  const std::uint32_t count = field_.size(message);
  for (std::uint32_t i = 0; i < count; ++i) {
    const double value = field_.read(message, i);
    if (math::is_finite(value) && (math::is_nan(worst) || margin(value) < margin(worst))) worst = value;
  }
  return worst;
}

bool Failsafe::look_value(Time now) noexcept {
  if (is_new()) {
    measured_ = math::canonical(worst_of(port_.get()));
    const bool good = math::is_finite(measured_) && margin(measured_) >= 0;
    if (!good && !bad_) since_ = port_.header(0)->published;
    bad_ = !good;
  }
  return bad_ && now - since_ >= spec_.time;
}

}  // namespace sinew::rt
