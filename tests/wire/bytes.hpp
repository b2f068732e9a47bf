#pragma once
// Bytes as tests write them.
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace sinew::wire::test {

using Bytes = std::vector<std::uint8_t>;

inline Bytes bytes_of(std::string_view text) { return {text.begin(), text.end()}; }

/// The frames that a scanner finds in `stream`.
template <class Scanner>
std::vector<Bytes> frames_in(Scanner& scanner, std::span<const std::uint8_t> stream) {
  std::vector<Bytes> out;
  for (const std::uint8_t b : stream)
    scanner.push(b, [&](std::span<const std::uint8_t> f) { out.emplace_back(f.begin(), f.end()); });
  return out;
}

/// All parts, one after the other.
inline Bytes joined(std::initializer_list<Bytes> parts) {
  Bytes out;
  for (const Bytes& p : parts) out.insert(out.end(), p.begin(), p.end());
  return out;
}

}  // namespace sinew::wire::test
