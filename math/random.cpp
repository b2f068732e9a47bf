#include "math/random.hpp"

#include "math/elementary.hpp"

namespace sinew::math {

std::array<std::uint32_t, 4> philox4x32(std::array<std::uint32_t, 4> c, std::array<std::uint32_t, 2> key) {
  constexpr std::uint64_t kMultiplier0 = 0xD2511F53, kMultiplier1 = 0xCD9E8D57;
  constexpr std::uint32_t kWeyl0 = 0x9E3779B9, kWeyl1 = 0xBB67AE85;
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t p0 = kMultiplier0 * c[0], p1 = kMultiplier1 * c[2];
    c = {static_cast<std::uint32_t>(p1 >> 32) ^ c[1] ^ key[0], static_cast<std::uint32_t>(p1),
         static_cast<std::uint32_t>(p0 >> 32) ^ c[3] ^ key[1], static_cast<std::uint32_t>(p0)};
    key[0] += kWeyl0, key[1] += kWeyl1;
  }
  return c;
}

void Random::refill() {
  words_ = philox4x32(counter_, key_);
  ++counter_[0];
  used_ = 0;
}

std::uint32_t Random::below(std::uint32_t n) {
  // D. Lemire, Fast random integer generation in an interval, ACM TOMACS 29 (2019).
  std::uint64_t product = std::uint64_t{next_u32()} * n;
  if (static_cast<std::uint32_t>(product) < n) {
    const std::uint32_t reject_below = n == 0 ? 0 : (0u - n) % n;
    while (static_cast<std::uint32_t>(product) < reject_below) product = std::uint64_t{next_u32()} * n;
  }
  return static_cast<std::uint32_t>(product >> 32);
}

double Random::normal() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  const double u = 1 - uniform();  // 0 < u <= 1
  const SinCos direction = sincos(2 * kPi * uniform());
  const double radius = sqrt(-2 * log(u));
  spare_ = radius * direction.sin;
  has_spare_ = true;
  return radius * direction.cos;
}

}  // namespace sinew::math
