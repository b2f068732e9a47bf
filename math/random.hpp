#pragma once
// Random numbers that are a function of (seed, stream, counter): a step draws the same numbers however often and in
// whatever order steps are executed.
#include <array>
#include <cstdint>

namespace sinew::math {

/// Four words from a 128-bit counter and a 64-bit key.
/// Source:  Philox4x32-10 of J. Salmon et al., Parallel random numbers: as easy as 1, 2, 3, SC'11, section 3.2.
std::array<std::uint32_t, 4> philox4x32(std::array<std::uint32_t, 4> counter, std::array<std::uint32_t, 2> key);

/// Generator for one step: rt seeds it with (run, module, step). Making one costs nothing, numbers come on demand.
/// Shape:   2^34 words per (seed, stream, counter), then they repeat.
/// Thread:  owner.   RT: yes.
class Random {
 public:
  constexpr explicit Random(std::uint64_t seed = 0, std::uint32_t stream = 0, std::uint64_t counter = 0)
      : key_{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)},
        counter_{0, static_cast<std::uint32_t>(counter), static_cast<std::uint32_t>(counter >> 32), stream} {}

  std::uint32_t next_u32() {
    if (used_ == 4) refill();
    return words_[used_++];
  }
  std::uint64_t next_u64() {
    const std::uint64_t low = next_u32();
    return low | std::uint64_t{next_u32()} << 32;
  }
  /// 0 <= value < 1, in steps of 2^-53.
  double uniform() { return static_cast<double>(next_u64() >> 11) * 0x1p-53; }
  /// low <= value <= high; high itself only by rounding.
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// 0 <= value < n without bias; 0 for n = 0. Draws again in less than n / 2^32 of the cases.
  std::uint32_t below(std::uint32_t n);
  /// Mean 0, standard deviation 1.
  /// Source:  G. Box and M. Muller, A note on the generation of random normal deviates (1958); both values are used.
  double normal();
  double normal(double mean, double sigma) { return mean + sigma * normal(); }

 private:
  void refill();

  std::array<std::uint32_t, 2> key_;
  std::array<std::uint32_t, 4> counter_;
  std::array<std::uint32_t, 4> words_{};
  std::uint32_t used_ = 4;
  bool has_spare_ = false;
  double spare_ = 0;
};

}  // namespace sinew::math
