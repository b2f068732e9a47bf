// Compiled with -O3 (CMakeLists.txt), since these loops are what the compiler shall vectorise.
#include "images/pixel_rows.hpp"

#include <algorithm>

#if defined(__x86_64__) || defined(__i386__)
#include <immintrin.h>
#define SINEW_SSSE3 __attribute__((target("ssse3")))
#endif

namespace sinew::images {
namespace {

std::uint8_t clamped(int value) { return static_cast<std::uint8_t>(std::clamp(value, 0, 255)); }

// Factors in 1/65536. Luma has 219 steps and chroma 224, where full range has 255.
constexpr int kHalf = 1 << 15, kLuma = 76309, kChroma = 74606;

int full_luma(int y) { return ((y - 16) * kLuma + kHalf) >> 16; }
std::uint8_t full_chroma(int c) { return clamped((((c - 128) * kChroma + kHalf) >> 16) + 128); }

#ifdef SINEW_SSSE3
// Sixteen bytes a step, in 16-bit arithmetic. The compiler makes 32-bit arithmetic of the plain loops below, which
// takes four times as long. The results are equal for every byte (tests/images): 8 * n * factor / 65536 is twice n to
// full range, and the halving rounds.
#define SINEW_SSE2 __attribute__((target("sse2")))
constexpr std::int16_t kTwiceLuma = 19077, kTwiceChroma = 18652;

SINEW_SSE2 __m128i loaded(const std::uint8_t* from) { return _mm_loadu_si128(reinterpret_cast<const __m128i*>(from)); }
SINEW_SSE2 __m128i to_full(__m128i values, std::int16_t zero, std::int16_t twice) {
  const __m128i eightfold = _mm_slli_epi16(_mm_sub_epi16(values, _mm_set1_epi16(zero)), 3);
  const __m128i doubled = _mm_mulhi_epi16(eightfold, _mm_set1_epi16(twice));
  return _mm_srai_epi16(_mm_add_epi16(doubled, _mm_set1_epi16(1)), 1);
}

SINEW_SSE2 std::size_t luma_by_16(const std::uint8_t* in, std::size_t pixels, std::uint8_t* y) {
  const __m128i low = _mm_set1_epi16(0xFF);
  std::size_t i = 0;
  // The last byte of a step is no Y: behind the last pixel there may be nothing.
  for (; i + 16 < pixels; i += 16) {
    const __m128i a = to_full(_mm_and_si128(loaded(in + 2 * i), low), 16, kTwiceLuma);
    const __m128i b = to_full(_mm_and_si128(loaded(in + 2 * i + 16), low), 16, kTwiceLuma);
    _mm_storeu_si128(reinterpret_cast<__m128i*>(y + i), _mm_packus_epi16(a, b));
  }
  return i;
}

/// U and V of four pairs, in turn, of the mean of two rows.
SINEW_SSE2 __m128i chroma_of_eight(const std::uint8_t* in, const std::uint8_t* below) {
  const __m128i pixels = _mm_avg_epu8(loaded(in), loaded(below));
  return _mm_add_epi16(to_full(_mm_srli_epi16(pixels, 8), 128, kTwiceChroma), _mm_set1_epi16(128));
}

SINEW_SSE2 std::size_t chroma_by_16(const std::uint8_t* in, const std::uint8_t* below, std::size_t pairs,
                                    std::uint8_t* u, std::uint8_t* v) {
  const __m128i low = _mm_set1_epi16(0xFF);
  std::size_t i = 0;
  for (; i + 16 <= pairs; i += 16) {
    const std::uint8_t *const one = in + 4 * i, *const other = below + 4 * i;
    const __m128i a = _mm_packus_epi16(chroma_of_eight(one, other), chroma_of_eight(one + 16, other + 16));
    const __m128i b = _mm_packus_epi16(chroma_of_eight(one + 32, other + 32), chroma_of_eight(one + 48, other + 48));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(u + i), _mm_packus_epi16(_mm_and_si128(a, low), _mm_and_si128(b, low)));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(v + i), _mm_packus_epi16(_mm_srli_epi16(a, 8), _mm_srli_epi16(b, 8)));
  }
  return i;
}

bool has_sse2() {
  static const bool has = __builtin_cpu_supports("sse2");
  return has;
}

/// Five pixels a step; a step touches 16 bytes, so the last pixels are left to the caller. Returns how many are done.
SINEW_SSSE3 std::size_t swap_by_shuffle(const std::uint8_t* in, std::size_t pixels, std::uint8_t* out) {
  const __m128i order = _mm_setr_epi8(2, 1, 0, 5, 4, 3, 8, 7, 6, 11, 10, 9, 14, 13, 12, 15);
  std::size_t i = 0;
  for (; i + 6 <= pixels; i += 5) {
    const __m128i five = _mm_loadu_si128(reinterpret_cast<const __m128i*>(in + 3 * i));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(out + 3 * i), _mm_shuffle_epi8(five, order));
  }
  return i;
}
#endif

}  // namespace

void swap_red_and_blue(const std::uint8_t* in, std::size_t pixels, std::uint8_t* out) {
  std::size_t i = 0;
#ifdef SINEW_SSSE3
  static const bool has_shuffle = __builtin_cpu_supports("ssse3");
  if (has_shuffle) i = swap_by_shuffle(in, pixels, out);
#endif
  for (; i < pixels; ++i) {
    const std::uint8_t a = in[3 * i], b = in[3 * i + 1], c = in[3 * i + 2];
    out[3 * i] = c, out[3 * i + 1] = b, out[3 * i + 2] = a;
  }
}

void grey_to_colour(const std::uint8_t* __restrict in, std::size_t pixels, std::uint8_t* __restrict out) {
  for (std::size_t i = 0; i < pixels; ++i) out[3 * i] = out[3 * i + 1] = out[3 * i + 2] = in[i];
}

void yuyv_to_colour(const std::uint8_t* __restrict in, bool odd, std::size_t pixels, bool bgr,
                    std::uint8_t* __restrict out) {
  const int red_at = bgr ? 2 : 0;
  std::size_t at = odd ? 1 : 0;
  constexpr int kRedOfV = 104597, kGreenOfU = 25675, kGreenOfV = 53279, kBlueOfU = 132201;
  const auto put = [&](int red, int green, int blue) {
    out[red_at] = clamped(red >> 16), out[1] = clamped(green >> 16), out[2 - red_at] = clamped(blue >> 16);
    out += 3;
  };
  for (const std::size_t end = at + pixels; at < end;) {
    const std::uint8_t* pair = in + at / 2 * 4;
    const int u = pair[1] - 128, v = pair[3] - 128;
    const auto pixel = [&](int y) {
      const int luma = (y - 16) * kLuma + kHalf;
      put(luma + kRedOfV * v, luma - kGreenOfU * u - kGreenOfV * v, luma + kBlueOfU * u);
      ++at;
    };
    if (at % 2 == 0) pixel(pair[0]);
    if (at < end) pixel(pair[2]);
  }
}

void luma_of_yuyv(const std::uint8_t* __restrict in, std::size_t pixels, std::uint8_t* __restrict y) {
  std::size_t i = 0;
#ifdef SINEW_SSE2
  if (has_sse2()) i = luma_by_16(in, pixels, y);
#endif
  for (; i < pixels; ++i) y[i] = clamped(full_luma(in[2 * i]));
}

void chroma_of_yuyv(const std::uint8_t* __restrict in, std::size_t pairs, std::uint8_t* __restrict u,
                    std::uint8_t* __restrict v) {
  std::size_t i = 0;
#ifdef SINEW_SSE2
  if (has_sse2()) i = chroma_by_16(in, in, pairs, u, v);
#endif
  for (; i < pairs; ++i) u[i] = full_chroma(in[4 * i + 1]), v[i] = full_chroma(in[4 * i + 3]);
}

void mean_chroma_of_yuyv(const std::uint8_t* __restrict in, const std::uint8_t* __restrict below, std::size_t pairs,
                         std::uint8_t* __restrict u, std::uint8_t* __restrict v) {
  std::size_t i = 0;
#ifdef SINEW_SSE2
  if (has_sse2()) i = chroma_by_16(in, below, pairs, u, v);
#endif
  for (; i < pairs; ++i) {
    u[i] = full_chroma((in[4 * i + 1] + below[4 * i + 1] + 1) >> 1);
    v[i] = full_chroma((in[4 * i + 3] + below[4 * i + 3] + 1) >> 1);
  }
}

void subtract_left(const std::uint8_t* __restrict in, std::size_t bytes, std::size_t distance,
                   std::uint8_t* __restrict out) {
  const std::size_t first = std::min(bytes, distance);
  std::copy_n(in, first, out);
  for (std::size_t i = first; i < bytes; ++i) out[i] = static_cast<std::uint8_t>(in[i] - in[i - distance]);
}

void add_weighted(const std::uint8_t* __restrict in, std::size_t count, std::uint32_t weight,
                  std::uint32_t* __restrict sums) {
  if (weight == 1)
    for (std::size_t i = 0; i < count; ++i) sums[i] += in[i];
  else
    for (std::size_t i = 0; i < count; ++i) sums[i] += weight * in[i];
}

}  // namespace sinew::images
