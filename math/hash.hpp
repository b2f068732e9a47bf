#pragma once
// Hashes of bytes, the same on every machine (words are read as little-endian). Not secure against an adversary.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace sinew::math {

/// For names and texts.
/// Source:  G. Fowler, L. Noll, K.-P. Vo; FNV-1a, 64 bits.
constexpr std::uint64_t fnv1a64(std::string_view text, std::uint64_t state = 0xcbf29ce484222325) {
  for (const char c : text) state = (state ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return state;
}

/// For messages and megabytes of pixels, in pieces of any size: pieces and the whole give the same value.
/// Source:  Y. Collet, XXH64 of the xxHash fast digest algorithm specification 0.1.1.
/// Thread:  owner.   RT: yes.
class Hash64 {
 public:
  explicit Hash64(std::uint64_t seed = 0);
  void add(const void* bytes, std::size_t n);
  /// The hash of everything added so far; more may follow.
  std::uint64_t value() const;

 private:
  static constexpr std::size_t kBlock = 32;
  void add_block(const std::byte* block);

  std::uint64_t seed_;
  std::array<std::uint64_t, 4> lanes_;
  std::uint64_t total_ = 0;
  std::size_t held_ = 0;  // bytes waiting in the buffer
  std::array<std::byte, kBlock> buffer_;
};

std::uint64_t hash64(const void* bytes, std::size_t n, std::uint64_t seed = 0);

}  // namespace sinew::math
