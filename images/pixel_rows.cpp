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
  for (std::size_t i = 0; i < pixels; ++i) y[i] = clamped(full_luma(in[2 * i]));
}

void chroma_of_yuyv(const std::uint8_t* __restrict in, std::size_t pairs, std::uint8_t* __restrict u,
                    std::uint8_t* __restrict v) {
  for (std::size_t i = 0; i < pairs; ++i) u[i] = full_chroma(in[4 * i + 1]), v[i] = full_chroma(in[4 * i + 3]);
}

void mean_chroma_of_yuyv(const std::uint8_t* __restrict in, const std::uint8_t* __restrict below, std::size_t pairs,
                         std::uint8_t* __restrict u, std::uint8_t* __restrict v) {
  for (std::size_t i = 0; i < pairs; ++i) {
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
