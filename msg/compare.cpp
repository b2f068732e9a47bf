#include "msg/compare.hpp"

#include <cstring>

#include "msg/text.hpp"

namespace sinew::msg {
namespace {

template <class Bits>
void canonicalise_run(std::byte* p, std::uint32_t count, Bits infinity, Bits nan) {
  constexpr Bits kMagnitude = static_cast<Bits>(~Bits{0}) >> 1;
  for (std::uint32_t i = 0; i < count; ++i, p += sizeof(Bits)) {
    Bits bits;
    std::memcpy(&bits, p, sizeof bits);
    if ((bits & kMagnitude) > infinity) std::memcpy(p, &nan, sizeof nan);
  }
}

std::string as_text(Kind kind, const std::byte* p) {
  std::string text;
  append_number(kind, p, text);
  return text;
}

std::string as_bits(const std::byte* p, std::uint32_t size) {
  std::string text = "0x";
  for (std::uint32_t i = size; i-- > 0;) append_hex({reinterpret_cast<const std::uint8_t*>(p) + i, 1}, text);
  return text;
}

std::optional<Difference> number_difference(Kind kind, const std::byte* a, const std::byte* b,
                                            const std::string& path) {
  const std::uint32_t size = size_of(kind);
  if (std::memcmp(a, b, size) == 0) return std::nullopt;
  Difference d{path, as_text(kind, a), as_text(kind, b)};
  if (d.a == d.b) d.a += " " + as_bits(a, size), d.b += " " + as_bits(b, size);
  return d;
}

std::optional<Difference> field_difference(const TypeInfo& type, const std::byte* a, const std::byte* b,
                                           const std::string& prefix) {
  for (const FieldInfo& f : type.fields) {
    const std::uint32_t step = f.kind == Kind::nested ? f.nested->size : size_of(f.kind);
    for (std::uint32_t i = 0; i < f.count; ++i) {
      const std::byte *at_a = a + f.offset + i * step, *at_b = b + f.offset + i * step;
      if (std::memcmp(at_a, at_b, step) == 0) continue;
      std::string path = prefix + std::string(f.name);
      if (f.is_array) path += "[" + std::to_string(i) + "]";
      return f.kind == Kind::nested ? field_difference(*f.nested, at_a, at_b, path + ".")
                                    : number_difference(f.kind, at_a, at_b, path);
    }
  }
  return std::nullopt;
}

}  // namespace

void canonicalise(const TypeInfo& type, void* message) {
  for (const FloatRun& run : type.floats) {
    std::byte* p = static_cast<std::byte*>(message) + run.offset;
    if (run.is_f64)
      canonicalise_run<std::uint64_t>(p, run.count, 0x7ff0000000000000, 0x7ff8000000000000);
    else
      canonicalise_run<std::uint32_t>(p, run.count, 0x7f800000, 0x7fc00000);
  }
}

bool equal(const TypeInfo& type, const void* a, const void* b) {
  if (std::memcmp(a, b, type.size) != 0) return false;
  const auto bulk_a = bulk_of(type, a), bulk_b = bulk_of(type, b);  // same size, as all fields are equal
  return bulk_a.empty() || std::memcmp(bulk_a.data(), bulk_b.data(), bulk_a.size()) == 0;
}

std::optional<Difference> first_difference(const TypeInfo& type, const void* a, const void* b) {
  if (auto d = field_difference(type, static_cast<const std::byte*>(a), static_cast<const std::byte*>(b), "")) return d;
  const auto bulk_a = bulk_of(type, a), bulk_b = bulk_of(type, b);
  for (std::size_t i = 0; i < bulk_a.size(); ++i)
    if (bulk_a[i] != bulk_b[i])
      return Difference{std::string(type.bulk_name) + "[" + std::to_string(i) + "]", std::to_string(bulk_a[i]),
                        std::to_string(bulk_b[i])};
  return std::nullopt;
}

}  // namespace sinew::msg
