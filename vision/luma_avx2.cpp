// Bins of pixels, 32 of them a step: rows are added as 16-bit numbers, neighbours by widening multiply-adds.
#include "vision/luma.hpp"

#ifdef SINEW_VISION_AVX2
#include <immintrin.h>

#include <bit>

#define SINEW_AVX2 __attribute__((target("avx2")))
#define SINEW_AVX2_INLINE __attribute__((target("avx2"), always_inline)) inline

namespace sinew::vision::detail {
namespace {

constexpr std::uint32_t kAtOnce = 32;  // results

/// 32 bytes of `Rows` rows, added: of yuyv the Y of 16 pixels, of mono8 the sums of 16 pairs. Recursions in place of
/// loops: without them the compiler keeps the sums in memory.
template <bool Yuyv, std::uint32_t Rows>
SINEW_AVX2_INLINE __m256i row_sums(const std::uint8_t* p, std::size_t stride) {
  const __m256i v = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p));
  const __m256i one =
      Yuyv ? _mm256_and_si256(v, _mm256_set1_epi16(0xff)) : _mm256_maddubs_epi16(v, _mm256_set1_epi8(1));
  if constexpr (Rows == 1)
    return one;
  else
    return _mm256_add_epi16(one, row_sums<Yuyv, Rows - 1>(p + stride, stride));
}

/// Eight sums as 32-bit numbers, each of `Lanes` neighbours of row_sums().
template <bool Yuyv, std::uint32_t Bin, std::uint32_t Lanes>
SINEW_AVX2_INLINE __m256i eight_sums(const std::uint8_t* p, std::size_t stride) {
  if constexpr (Lanes == 2) {
    return _mm256_madd_epi16(row_sums<Yuyv, Bin>(p, stride), _mm256_set1_epi16(1));
  } else {
    const __m256i a = eight_sums<Yuyv, Bin, Lanes / 2>(p, stride);
    const __m256i b = eight_sums<Yuyv, Bin, Lanes / 2>(p + 8 * Lanes, stride);
    return _mm256_permute4x64_epi64(_mm256_hadd_epi32(a, b), 0xD8);
  }
}

template <bool Yuyv, std::uint32_t Bin>
SINEW_AVX2_INLINE __m256i eight_means(const std::uint8_t* p, std::size_t stride) {
  constexpr int kArea = Bin * Bin;
  const __m256i sum = eight_sums < Yuyv, Bin, Yuyv ? Bin : Bin / 2 > (p, stride);
  return _mm256_srli_epi32(_mm256_add_epi32(sum, _mm256_set1_epi32(kArea / 2)), std::countr_zero(Bin * Bin));
}

template <bool Yuyv, std::uint32_t Bin>
SINEW_AVX2_INLINE __m256i all_means(const std::uint8_t* p, std::size_t stride) {
  constexpr std::uint32_t kPixel = Yuyv ? 2 : 1, kEight = 8 * Bin * kPixel;
  if constexpr (Bin * kPixel <= 2) {  // a sum is a lane of row_sums()
    const __m256i half = _mm256_set1_epi16(Bin * Bin / 2);
    constexpr int kShift = std::countr_zero(Bin * Bin);
    const __m256i a = _mm256_srli_epi16(_mm256_add_epi16(row_sums<Yuyv, Bin>(p, stride), half), kShift);
    const __m256i b = _mm256_srli_epi16(_mm256_add_epi16(row_sums<Yuyv, Bin>(p + 32, stride), half), kShift);
    return _mm256_permute4x64_epi64(_mm256_packus_epi16(a, b), 0xD8);
  } else {
    const __m256i a = _mm256_packs_epi32(eight_means<Yuyv, Bin>(p, stride), eight_means<Yuyv, Bin>(p + kEight, stride));
    const __m256i b = _mm256_packs_epi32(eight_means<Yuyv, Bin>(p + 2 * kEight, stride),
                                         eight_means<Yuyv, Bin>(p + 3 * kEight, stride));
    return _mm256_permutevar8x32_epi32(_mm256_packus_epi16(a, b), _mm256_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7));
  }
}

template <bool Yuyv, std::uint32_t Bin>
SINEW_AVX2 std::uint32_t bin_columns(const ImageView& image, std::uint32_t width, std::uint32_t height,
                                     std::uint8_t* out) {
  constexpr std::uint32_t kPixel = Yuyv ? 2 : 1;
  const std::uint32_t done = width / kAtOnce * kAtOnce;
  for (std::uint32_t y = 0; y < height; ++y, out += width) {
    const std::uint8_t* in = image.row(y * Bin);
    for (std::uint32_t x = 0; x < done; x += kAtOnce, in += kAtOnce * Bin * kPixel)
      _mm256_storeu_si256(reinterpret_cast<__m256i*>(out + x), all_means<Yuyv, Bin>(in, image.stride));
  }
  return done;
}

template <bool Yuyv>
BinColumns bin_columns_of(std::uint32_t bin) {
  switch (bin) {
    case 1:
      return Yuyv ? bin_columns<true, 1> : nullptr;
    case 2:
      return bin_columns<Yuyv, 2>;
    case 4:
      return bin_columns<Yuyv, 4>;
    case 8:
      return bin_columns<Yuyv, 8>;
    default:
      return nullptr;
  }
}

}  // namespace

BinColumns bin_columns_avx2(bool yuyv, std::uint32_t bin) {
  return yuyv ? bin_columns_of<true>(bin) : bin_columns_of<false>(bin);
}

}  // namespace sinew::vision::detail
#endif
