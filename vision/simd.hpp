#pragma once
// Which of two kernels runs. Both give the same bits, so the choice never shows in a result.
// Not on 32-bit Arm: NEON is optional there and only the operating system knows whether it exists, and its floating
// point has no division, no root and no numbers below 1e-38.
#include <cstdint>

#if defined(__x86_64__)
#define SINEW_VISION_AVX2 1  // compiled in by function attributes; chosen at run time
#elif defined(__aarch64__)
#define SINEW_VISION_NEON 1  // every processor has it
#endif

namespace sinew::vision {

enum class Simd : std::uint8_t { scalar, avx2, neon };

/// The fastest kernel that this processor runs. A kernel that is not in this build counts as scalar.
inline Simd best_simd() {
#ifdef SINEW_VISION_AVX2
  if (__builtin_cpu_supports("avx2")) return Simd::avx2;
#elif defined(SINEW_VISION_NEON)
  return Simd::neon;
#endif
  return Simd::scalar;
}

}  // namespace sinew::vision
