#pragma once
// Comparing messages: one bit pattern for every NaN, only the bytes that count, and where two messages differ.
#include <concepts>
#include <optional>
#include <string>

#include "msg/bulk.hpp"

namespace sinew::msg {

/// Gives every NaN in the fields the one bit pattern 0x7ff8... (0x7fc0... for float), because CPUs invent different
/// ones. rt does so at commit.   RT: yes; nothing at all for types without floating-point fields.
void canonicalise(const TypeInfo& type, void* message);

/// Feeds the bytes that count to a hash such as math::Hash64: all fields and the used bulk.   RT: yes.
template <class Hash>
requires requires(Hash& h, const void* p, std::size_t n) { h.add(p, n); }
void add_to_hash(Hash& hash, const TypeInfo& type, const void* message) {
  hash.add(message, type.size);  // no padding inside, see check_layout()
  if (type.has_bulk()) {
    const auto bulk = bulk_of(type, message);
    hash.add(bulk.data(), bulk.size());
  }
}

/// Compares the bytes that count bit by bit; two NaNs of one pattern are equal, 0.0 and -0.0 are not.   RT: yes.
bool equal(const TypeInfo& type, const void* a, const void* b);

struct Difference {
  std::string path;  // "gyro_radps.x", "value[3]" or "data[1024]"
  std::string a, b;  // the values as text; NaNs of different patterns as hex
};

/// Nothing when equal() holds.
std::optional<Difference> first_difference(const TypeInfo& type, const void* a, const void* b);

}  // namespace sinew::msg
