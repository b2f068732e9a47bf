// The box thresholds on 32 pixels a step. Integers only: exactly the runs of the scalar kernel.
#include <cstring>

#include "vision/mask_runs.hpp"
#include "vision/segmentation.hpp"

#ifdef SINEW_VISION_AVX2
#include <immintrin.h>

#define SINEW_AVX2 __attribute__((target("avx2")))
#define SINEW_AVX2_INLINE __attribute__((target("avx2"), always_inline)) inline

namespace sinew::vision::detail {
namespace {

/// Thresholds as unsigned distance from `lo`; nothing is inside when lo > hi.
struct BoxLanes {
  __m256i lo[3], span[3];
  std::uint32_t possible = ~0u;
};

struct Planes {
  __m256i y, u, v;  // 32 pixels
};

SINEW_AVX2_INLINE Planes planes_of(const std::uint8_t* p) {
  const __m256i yu = _mm256_setr_epi8(0, 2, 4, 6, 8, 10, 12, 14, 1, 1, 5, 5, 9, 9, 13, 13,  //
                                      0, 2, 4, 6, 8, 10, 12, 14, 1, 1, 5, 5, 9, 9, 13, 13);
  const __m256i vv = _mm256_setr_epi8(3, 3, 7, 7, 11, 11, 15, 15, 3, 3, 7, 7, 11, 11, 15, 15,  //
                                      3, 3, 7, 7, 11, 11, 15, 15, 3, 3, 7, 7, 11, 11, 15, 15);
  const __m256i r0 = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p));
  const __m256i r1 = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p + 32));
  const __m256i a0 = _mm256_shuffle_epi8(r0, yu), a1 = _mm256_shuffle_epi8(r1, yu);
  const __m256i v = _mm256_unpacklo_epi64(_mm256_shuffle_epi8(r0, vv), _mm256_shuffle_epi8(r1, vv));
  return {_mm256_permute4x64_epi64(_mm256_unpacklo_epi64(a0, a1), 0xD8),
          _mm256_permute4x64_epi64(_mm256_unpackhi_epi64(a0, a1), 0xD8), _mm256_permute4x64_epi64(v, 0xD8)};
}

/// One bit per pixel: inside the box.
SINEW_AVX2_INLINE std::uint32_t inside(const Planes& p, const BoxLanes& b) {
  __m256i out = _mm256_subs_epu8(_mm256_sub_epi8(p.y, b.lo[0]), b.span[0]);
  out = _mm256_or_si256(out, _mm256_subs_epu8(_mm256_sub_epi8(p.u, b.lo[1]), b.span[1]));
  out = _mm256_or_si256(out, _mm256_subs_epu8(_mm256_sub_epi8(p.v, b.lo[2]), b.span[2]));
  return static_cast<std::uint32_t>(_mm256_movemask_epi8(_mm256_cmpeq_epi8(out, _mm256_setzero_si256())));
}

}  // namespace

SINEW_AVX2 void box_runs_avx2(const ImageView& image, std::span<const ColourBox> boxes, RunJoiner* joiners) {
  BoxLanes lanes[kMaxColours];
  const std::size_t n = boxes.size();
  for (std::size_t c = 0; c < n; ++c)
    for (int k = 0; k < 3; ++k) {
      const std::uint8_t lo = boxes[c].lo[k], hi = boxes[c].hi[k];
      if (lo > hi) lanes[c].possible = 0;
      lanes[c].lo[k] = _mm256_set1_epi8(static_cast<char>(lo));
      lanes[c].span[k] = _mm256_set1_epi8(static_cast<char>(hi - lo));
    }
  const std::uint32_t whole = image.width / 32 * 32, rest = image.width - whole;
  for (std::uint32_t y = 0; y < image.height; ++y) {
    const std::uint8_t* p = image.row(y);
    MaskRow state[kMaxColours];
    for (std::uint32_t x = 0; x < whole; x += 32, p += 64) {
      const Planes planes = planes_of(p);
      for (std::size_t c = 0; c < n; ++c)
        add_mask(inside(planes, lanes[c]) & lanes[c].possible, y, x, state[c], joiners[c]);
    }
    if (rest != 0) {
      std::uint8_t padded[64] = {};
      std::memcpy(padded, p, std::size_t{rest} * 2);
      const Planes planes = planes_of(padded);
      const std::uint32_t valid = (1u << rest) - 1;
      for (std::size_t c = 0; c < n; ++c)
        add_mask(inside(planes, lanes[c]) & lanes[c].possible & valid, y, whole, state[c], joiners[c]);
    }
    for (std::size_t c = 0; c < n; ++c) {
      if (state[c].carry != 0) joiners[c].add(y, state[c].from, image.width);
      joiners[c].end_row();
    }
  }
}

}  // namespace sinew::vision::detail
#endif
