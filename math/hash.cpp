#include "math/hash.hpp"

#include <bit>
#include <cstring>

namespace sinew::math {
namespace {

constexpr std::uint64_t kPrime1 = 0x9E3779B185EBCA87, kPrime2 = 0xC2B2AE3D27D4EB4F, kPrime3 = 0x165667B19E3779F9,
                        kPrime4 = 0x85EBCA77C2B2AE63, kPrime5 = 0x27D4EB2F165667C5;

template <class Word>
std::uint64_t load(const std::byte* p) {
  Word w;
  std::memcpy(&w, p, sizeof w);
  if constexpr (std::endian::native == std::endian::big)
    w = sizeof w == 8 ? static_cast<Word>(__builtin_bswap64(w)) : static_cast<Word>(__builtin_bswap32(w));
  return w;
}

std::uint64_t mix(std::uint64_t lane, std::uint64_t word) { return std::rotl(lane + word * kPrime2, 31) * kPrime1; }

std::uint64_t merge(std::uint64_t h, std::uint64_t lane) { return (h ^ mix(0, lane)) * kPrime1 + kPrime4; }

}  // namespace

Hash64::Hash64(std::uint64_t seed)
    : seed_(seed), lanes_{seed + kPrime1 + kPrime2, seed + kPrime2, seed, seed - kPrime1} {}

inline void Hash64::add_block(const std::byte* block) {
  for (std::size_t i = 0; i < 4; ++i) lanes_[i] = mix(lanes_[i], load<std::uint64_t>(block + 8 * i));
}

void Hash64::add(const void* bytes, std::size_t n) {
  if (n == 0) return;
  auto p = static_cast<const std::byte*>(bytes);
  total_ += n;
  if (held_ > 0) {
    const std::size_t wanted = kBlock - held_, taken = n < wanted ? n : wanted;
    std::memcpy(buffer_.data() + held_, p, taken);
    held_ += taken, p += taken, n -= taken;
    if (held_ < kBlock) return;
    add_block(buffer_.data());
    held_ = 0;
  }
  for (; n >= kBlock; p += kBlock, n -= kBlock) add_block(p);
  if (n > 0) std::memcpy(buffer_.data(), p, n);
  held_ = n;
}

std::uint64_t Hash64::value() const {
  std::uint64_t h = seed_ + kPrime5;
  if (total_ >= kBlock) {
    h = std::rotl(lanes_[0], 1) + std::rotl(lanes_[1], 7) + std::rotl(lanes_[2], 12) + std::rotl(lanes_[3], 18);
    for (const std::uint64_t lane : lanes_) h = merge(h, lane);
  }
  h += total_;
  const std::byte* p = buffer_.data();
  std::size_t n = held_;
  for (; n >= 8; p += 8, n -= 8) h = std::rotl(h ^ mix(0, load<std::uint64_t>(p)), 27) * kPrime1 + kPrime4;
  if (n >= 4) {
    h = std::rotl(h ^ load<std::uint32_t>(p) * kPrime1, 23) * kPrime2 + kPrime3;
    p += 4, n -= 4;
  }
  for (; n > 0; ++p, --n) h = std::rotl(h ^ std::to_integer<std::uint64_t>(*p) * kPrime5, 11) * kPrime1;
  h = (h ^ (h >> 33)) * kPrime2;
  h = (h ^ (h >> 29)) * kPrime3;
  return h ^ (h >> 32);
}

std::uint64_t hash64(const void* bytes, std::size_t n, std::uint64_t seed) {
  Hash64 h(seed);
  h.add(bytes, n);
  return h.value();
}

}  // namespace sinew::math
