#pragma once
// One number of a message as text: the shortest digits that read back to the same bits.
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "msg/describe.hpp"

namespace sinew::msg {

constexpr std::uint32_t size_of(Kind k) {
  switch (k) {
    case Kind::i8:
    case Kind::u8:
      return 1;
    case Kind::i16:
    case Kind::u16:
      return 2;
    case Kind::i32:
    case Kind::u32:
    case Kind::f32:
      return 4;
    case Kind::i64:
    case Kind::u64:
    case Kind::f64:
      return 8;
    case Kind::nested:
      return 0;
  }
  return 0;
}
constexpr bool is_float(Kind k) { return k == Kind::f32 || k == Kind::f64; }

/// What a description says of a field besides its unit: "0 standby, 1 armed; the worst of all groups", "bits: 1 lease,
/// 2 not finite; now", or only the doc text.
std::string remark_of(const FieldInfo& field);

/// Appends the number at p. Floating-point numbers always show a point or exponent (1.0, -0.0, 1e-300); NaN, Infinity
/// and -Infinity are written by these names.
void append_number(Kind kind, const void* p, std::string& out);

void append_hex(std::span<const std::uint8_t> bytes, std::string& out);
/// RFC 4648 section 4, padded.
void append_base64(std::span<const std::uint8_t> bytes, std::string& out);

}  // namespace sinew::msg
