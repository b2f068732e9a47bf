#include "record/run/quantity.hpp"

#include <cstring>

#include "math/linear.hpp"
#include "msg/geometry.hpp"
#include "msg/text.hpp"

namespace sinew::record {
namespace {

constexpr double kDegrees = 57.29577951308232;

template <class T>
T read(const void* p) {
  T value;
  std::memcpy(&value, p, sizeof value);
  return value;
}

double number(msg::Kind kind, const void* p) {
  switch (kind) {
    case msg::Kind::i8:
      return read<std::int8_t>(p);
    case msg::Kind::u8:
      return read<std::uint8_t>(p);
    case msg::Kind::i16:
      return read<std::int16_t>(p);
    case msg::Kind::u16:
      return read<std::uint16_t>(p);
    case msg::Kind::i32:
      return read<std::int32_t>(p);
    case msg::Kind::u32:
      return read<std::uint32_t>(p);
    case msg::Kind::i64:
      return static_cast<double>(read<std::int64_t>(p));
    case msg::Kind::u64:
      return static_cast<double>(read<std::uint64_t>(p));
    case msg::Kind::f32:
      return static_cast<double>(read<float>(p));
    case msg::Kind::f64:
      return read<double>(p);
    case msg::Kind::nested:
      break;
  }
  return 0;
}

/// Integers of 64 bits have more digits than a double, so they are subtracted as integers.
double number_difference(msg::Kind kind_a, const void* a, msg::Kind kind_b, const void* b) {
  if (kind_a == kind_b && (kind_a == msg::Kind::i64 || kind_a == msg::Kind::u64))
    return static_cast<double>(static_cast<std::int64_t>(read<std::uint64_t>(b) - read<std::uint64_t>(a)));
  return number(kind_b, b) - number(kind_a, a);
}

bool is_quat(const msg::FieldInfo& f) { return f.nested == &msg::type_info<msg::Quat>(); }

math::Quat quat_at(const void* p) { return math::Quat(read<msg::Quat>(p)); }

double tilt_rad(const math::Quat& a, const math::Quat& b) {
  const math::Vec3 up{0, 0, 1}, up_a = a.conjugate().rotate(up), up_b = b.conjugate().rotate(up);
  return math::atan2(math::norm(math::cross(up_a, up_b)), math::dot(up_a, up_b));
}

void add(const msg::TypeInfo& type, const std::string& prefix, std::string_view unit, std::uint32_t offset,
         std::vector<Quantity>& all) {
  for (const msg::FieldInfo& f : type.fields) {
    const std::uint32_t size = f.kind == msg::Kind::nested ? f.nested->size : msg::size_of(f.kind);
    for (std::uint32_t i = 0; i < f.count; ++i) {
      const std::string path =
          prefix + std::string(f.name) + (f.is_array ? "[" + std::to_string(i) + "]" : std::string());
      const std::string_view own = f.unit.empty() ? unit : f.unit;
      const std::uint32_t at = offset + f.offset + i * size;
      if (f.kind != msg::Kind::nested) {
        all.push_back({path, std::string(own), Quantity::What::number, f.kind, at});
        continue;
      }
      add(*f.nested, path + ".", own, at, all);
      if (!is_quat(f)) continue;
      all.push_back({path + ".angle", "deg", Quantity::What::angle, msg::Kind::f64, at});
      all.push_back({path + ".tilt", "deg", Quantity::What::tilt, msg::Kind::f64, at});
    }
  }
}

template <class Real>
void mix(const void* a, const void* b, double share, void* out) {
  const double from = static_cast<double>(read<Real>(a)), to = static_cast<double>(read<Real>(b));
  const Real value = static_cast<Real>(from + share * (to - from));
  std::memcpy(out, &value, sizeof value);
}

/// Samples are close together, so a line replaces the arc.
void mix_quat(const void* a, const void* b, double share, void* out) {
  const math::Quat from = quat_at(a), to = quat_at(b);
  const double dot = from.w * to.w + math::dot(from.vec(), to.vec()), s = 1 - share, t = dot < 0 ? -share : share;
  const math::Quat q{s * from.w + t * to.w, s * from.x + t * to.x, s * from.y + t * to.y, s * from.z + t * to.z};
  // An unknown attitude, all NaN, stays unknown.
  const msg::Quat mixed = math::is_finite(q) ? q.normalized().to<msg::Quat>() : q.to<msg::Quat>();
  std::memcpy(out, &mixed, sizeof mixed);
}

}  // namespace

double difference(const Quantity& of_a, const void* a, const Quantity& of_b, const void* b) {
  const void *at_a = static_cast<const std::byte*>(a) + of_a.offset,
             *at_b = static_cast<const std::byte*>(b) + of_b.offset;
  if (of_a.what == Quantity::What::number) return number_difference(of_a.kind, at_a, of_b.kind, at_b);
  const math::Quat q_a = quat_at(at_a), q_b = quat_at(at_b);
  if (q_a == q_b) return 0;  // exactly 0, without rounding errors
  return kDegrees * (of_a.what == Quantity::What::angle ? math::angle_between(q_a, q_b) : tilt_rad(q_a, q_b));
}

double Quantity::value(const void* message) const {
  return number(kind, static_cast<const std::byte*>(message) + offset);
}

std::vector<Quantity> quantities(const msg::TypeInfo& type) {
  std::vector<Quantity> all;
  add(type, "", "", 0, all);
  return all;
}

bool means(std::string_view pattern, std::string_view name) {
  const auto ends_part = [](char c) { return c == '.' || c == '['; };
  for (std::size_t at = 0; !pattern.empty() && (at = name.find(pattern, at)) != std::string_view::npos; ++at) {
    const std::size_t end = at + pattern.size();
    if ((at == 0 || name[at - 1] == '.') && (end == name.size() || ends_part(name[end]))) return true;
  }
  return false;
}

void interpolate(const msg::TypeInfo& type, const void* a, const void* b, double share, void* out) {
  for (const msg::FieldInfo& f : type.fields) {
    const std::uint32_t size = f.kind == msg::Kind::nested ? f.nested->size : msg::size_of(f.kind);
    for (std::uint32_t i = 0; i < f.count; ++i) {
      const std::uint32_t at = f.offset + i * size;
      const void *from = static_cast<const std::byte*>(a) + at, *to = static_cast<const std::byte*>(b) + at;
      void* result = static_cast<std::byte*>(out) + at;
      if (f.kind == msg::Kind::nested)
        is_quat(f) ? mix_quat(from, to, share, result) : interpolate(*f.nested, from, to, share, result);
      else if (f.kind == msg::Kind::f64)
        mix<double>(from, to, share, result);
      else if (f.kind == msg::Kind::f32)
        mix<float>(from, to, share, result);
      else
        std::memcpy(result, from, size);
    }
  }
}

}  // namespace sinew::record
