#pragma once
#include <cstdint>

namespace sinew::plant {

/// A stream of noise. One per noise source, so that adding a draw in one place changes no other.
/// Integers only, plus exact conversions: the same numbers on every machine.
/// Source:  SplitMix64 (Steele, Lea, Flood 2014).
class Noise {
 public:
  Noise(std::uint64_t seed, std::uint64_t stream) : state_(mix(seed ^ mix(stream + 0x9e3779b97f4a7c15u))) {}

  std::uint64_t next() {
    state_ += 0x9e3779b97f4a7c15u;
    return mix(state_);
  }
  /// In [0, 1).
  double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }
  /// In [-1, 1).
  double symmetric() { return 2.0 * uniform() - 1.0; }
  /// Mean 0, variance 1: the sum of four 16-bit uniforms (bounded by 3.47), which costs one draw.
  double gauss() {
    const std::uint64_t r = next();
    const auto sum =
        static_cast<double>((r & 0xffff) + ((r >> 16) & 0xffff) + ((r >> 32) & 0xffff) + (r >> 48)) - 2.0 * 65535.0;
    return sum * (1.7320508075688772 / 65536.0);  // a uniform of width 65536 has the variance 65536^2 / 12
  }

 private:
  static constexpr std::uint64_t mix(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  std::uint64_t state_;
};

}  // namespace sinew::plant
