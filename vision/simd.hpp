#pragma once
// Which of two kernels runs. Both give the same bits, so the choice is never visible in a result.
#include <cstdint>

#if defined(__x86_64__)
#define SINEW_VISION_AVX2 1  // compiled in by function attributes; chosen at run time
#endif

namespace sinew::vision {

enum class Simd : std::uint8_t { scalar, avx2 };

/// The fastest that this processor runs. A NEON variant gets its place here.
inline Simd best_simd() {
#ifdef SINEW_VISION_AVX2
  if (__builtin_cpu_supports("avx2")) return Simd::avx2;
#endif
  return Simd::scalar;
}

}  // namespace sinew::vision
