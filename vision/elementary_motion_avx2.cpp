// Elementary motion detection on 16 pixels a step: one widening multiply-add of pixel pairs is one correlator.
#include <array>

#include "vision/elementary_motion.hpp"

#ifdef SINEW_VISION_AVX2
#include <immintrin.h>

#define SINEW_AVX2 __attribute__((target("avx2")))
#define SINEW_AVX2_INLINE __attribute__((target("avx2"), always_inline)) inline

namespace sinew::vision::detail {
namespace {

SINEW_AVX2_INLINE __m128i load(const std::uint8_t* p) { return _mm_loadu_si128(reinterpret_cast<const __m128i*>(p)); }

/// Eight pixels (the lower or upper ones of 16) of a and b, interleaved, as 16-bit numbers.
template <bool Upper>
SINEW_AVX2_INLINE __m256i pairs(__m128i a, __m128i b) {
  return _mm256_cvtepu8_epi16(Upper ? _mm_unpackhi_epi8(a, b) : _mm_unpacklo_epi8(a, b));
}

/// Sixteen pixels of both frames with their neighbours.
struct Block {
  __m128i x1, x2, x1_right, x2_right, x1_down, x2_down;
};

struct Rows {
  const std::uint8_t *a, *b, *a_down, *b_down;
};

SINEW_AVX2_INLINE Block block_at(const Rows& r, std::uint32_t x) {
  return {load(r.a + x), load(r.b + x), load(r.a + x + 1), load(r.b + x + 1), load(r.a_down + x), load(r.b_down + x)};
}

SINEW_AVX2_INLINE Rows rows_at(const ImageView& older, const ImageView& newer, std::uint32_t y) {
  return {older.row(y), newer.row(y), older.row(y + 1), newer.row(y + 1)};
}

struct Lanes {
  __m256i mx, my;  // eight 32-bit correlators each
};

template <bool Upper>
SINEW_AVX2_INLINE Lanes correlate(const Block& k) {
  const __m256i plus_minus = _mm256_set1_epi32(static_cast<int>(0xffff0001u));   // (+1, -1)
  const __m256i base = _mm256_sign_epi16(pairs<Upper>(k.x2, k.x1), plus_minus);  // x2, -x1
  return {_mm256_madd_epi16(base, pairs<Upper>(k.x1_right, k.x2_right)),         // x2 x1' - x1 x2'
          _mm256_madd_epi16(base, pairs<Upper>(k.x1_down, k.x2_down))};
}

/// Equations 3 and 4 for eight pixels; the same operations in the same order as polar() in elementary_motion.cpp.
SINEW_AVX2_INLINE void store_polar(const Lanes& m, float* magnitude, float* direction_rad) {
  const __m256i ax = _mm256_abs_epi32(m.mx), ay = _mm256_abs_epi32(m.my);
  const __m256 small = _mm256_cvtepi32_ps(_mm256_min_epi32(ax, ay));
  const __m256 large = _mm256_cvtepi32_ps(_mm256_max_epi32(ax, ay));
  const __m256 square = _mm256_add_ps(_mm256_mul_ps(large, large), _mm256_mul_ps(small, small));
  _mm256_storeu_ps(magnitude, _mm256_sqrt_ps(square));
  const __m256 a = _mm256_div_ps(small, _mm256_max_ps(large, _mm256_set1_ps(kTiny)));
  const __m256 s = _mm256_mul_ps(a, a), cube = _mm256_mul_ps(a, s);
  const __m256 first = _mm256_add_ps(a, _mm256_mul_ps(cube, _mm256_set1_ps(kAtan0)));
  const __m256 rest = _mm256_add_ps(_mm256_mul_ps(_mm256_set1_ps(kAtan2), s), _mm256_set1_ps(kAtan1));
  __m256 r = _mm256_add_ps(first, _mm256_mul_ps(_mm256_mul_ps(cube, s), rest));
  const __m256 steep = _mm256_castsi256_ps(_mm256_cmpgt_epi32(ay, ax));
  r = _mm256_blendv_ps(r, _mm256_sub_ps(_mm256_set1_ps(kHalfPi), r), steep);
  r = _mm256_blendv_ps(r, _mm256_sub_ps(_mm256_set1_ps(kPi), r), _mm256_castsi256_ps(m.mx));  // sign bits pick
  const __m256 sign = _mm256_and_ps(_mm256_castsi256_ps(m.my), _mm256_set1_ps(-0.0f));
  _mm256_storeu_ps(direction_rad, _mm256_or_ps(r, sign));
}

/// A row of both frames interleaved as 16-bit pairs (x1, x2): every pixel is unpacked once instead of three times.
using PairRow = std::array<std::uint32_t, msg::kMaxImageWidth>;

SINEW_AVX2_INLINE void interleave(const std::uint8_t* a, const std::uint8_t* b, std::uint32_t width, PairRow& out) {
  std::uint32_t x = 0;
  for (; x + 16 <= width; x += 16) {
    const __m128i x1 = load(a + x), x2 = load(b + x);
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(&out[x]), pairs<false>(x1, x2));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(&out[x + 8]), pairs<true>(x1, x2));
  }
  for (; x < width; ++x) out[x] = a[x] | std::uint32_t{b[x]} << 16;
}

SINEW_AVX2_INLINE __m256i load_pairs(const std::uint32_t* p) {
  return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p));
}

SINEW_AVX2_INLINE std::int64_t total(__m256i v) {
  alignas(32) std::int32_t lane[8];
  _mm256_store_si256(reinterpret_cast<__m256i*>(lane), v);
  std::int64_t sum = 0;
  for (int i = 0; i < 8; ++i) sum += lane[i];
  return sum;
}

/// Bytes `skip`..15 set: the pixels of the last, overlapping block that were not counted yet.
SINEW_AVX2_INLINE __m128i all_but_first(std::uint32_t skip) {
  const __m128i index = _mm_setr_epi8(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  return _mm_cmpgt_epi8(index, _mm_set1_epi8(static_cast<char>(static_cast<int>(skip) - 1)));
}

}  // namespace

SINEW_AVX2 void polar_avx2(const ImageView& older, const ImageView& newer, float* magnitude, float* direction_rad) {
  const std::uint32_t width = older.width, valid = width - 1;  // pixels of a row that have a right neighbour
  if (valid < 8 || width > msg::kMaxImageWidth) return polar_scalar(older, newer, magnitude, direction_rad);
  const __m256i swap_in_pair = _mm256_setr_epi8(2, 3, 0, 1, 6, 7, 4, 5, 10, 11, 8, 9, 14, 15, 12, 13,  //
                                                2, 3, 0, 1, 6, 7, 4, 5, 10, 11, 8, 9, 14, 15, 12, 13);
  const __m256i plus_minus = _mm256_set1_epi32(static_cast<int>(0xffff0001u));  // (+1, -1)
  alignas(32) PairRow rows[2];
  interleave(older.row(0), newer.row(0), width, rows[0]);
  for (std::uint32_t y = 0; y + 1 < older.height; ++y) {
    interleave(older.row(y + 1), newer.row(y + 1), width, rows[(y + 1) & 1]);
    const std::uint32_t *here = rows[y & 1].data(), *below = rows[(y + 1) & 1].data();
    float* const mag = magnitude + std::size_t{y} * width;
    float* const dir = direction_rad + std::size_t{y} * width;
    for (std::uint32_t x = 0;; x = x + 16 <= valid ? x + 8 : valid - 8) {  // the last block overlaps the one before
      const __m256i swapped = _mm256_shuffle_epi8(load_pairs(here + x), swap_in_pair);
      const __m256i base = _mm256_sign_epi16(swapped, plus_minus);  // x2, -x1
      store_polar({_mm256_madd_epi16(base, load_pairs(here + x + 1)), _mm256_madd_epi16(base, load_pairs(below + x))},
                  mag + x, dir + x);
      if (x + 8 == valid) break;
    }
  }
}

SINEW_AVX2 CorrelatorSums sums_avx2(const ImageView& older, const ImageView& newer) {
  const std::uint32_t valid = older.width - 1;
  if (valid < 16) return sums_scalar(older, newer);
  const std::uint32_t whole = valid / 16 * 16, last = valid - 16;
  const __m128i rest = all_but_first(whole - last);  // nothing when the blocks fit
  constexpr std::uint32_t kFlushRows = 128;          // 128 rows * 162 additions * 255^2 < 2^31
  CorrelatorSums sums;
  __m256i sx = _mm256_setzero_si256(), sy = sx;
  for (std::uint32_t y = 0; y + 1 < older.height; ++y) {
    const Rows rows = rows_at(older, newer, y);
    for (std::uint32_t x = 0; x < whole; x += 16) {
      const Block k = block_at(rows, x);
      const Lanes lo = correlate<false>(k), hi = correlate<true>(k);
      sx = _mm256_add_epi32(sx, _mm256_add_epi32(lo.mx, hi.mx));
      sy = _mm256_add_epi32(sy, _mm256_add_epi32(lo.my, hi.my));
    }
    Block k = block_at(rows, last);
    k.x1 = _mm_and_si128(k.x1, rest);
    k.x2 = _mm_and_si128(k.x2, rest);
    const Lanes lo = correlate<false>(k), hi = correlate<true>(k);
    sx = _mm256_add_epi32(sx, _mm256_add_epi32(lo.mx, hi.mx));
    sy = _mm256_add_epi32(sy, _mm256_add_epi32(lo.my, hi.my));
    if ((y + 1) % kFlushRows == 0 || y + 2 == older.height) {
      sums.x += total(sx);
      sums.y += total(sy);
      sx = sy = _mm256_setzero_si256();
    }
  }
  return sums;
}

namespace {

struct CellLanes {
  __m256i mx, my, gxx, gxy, gyy;
  __m128i older, newer;
};

SINEW_AVX2_INLINE __m256i both(const std::uint8_t* a, const std::uint8_t* b) {
  return _mm256_add_epi16(_mm256_cvtepu8_epi16(load(a)), _mm256_cvtepu8_epi16(load(b)));
}

/// `mask` chooses the pixels of the block that count.
SINEW_AVX2_INLINE void add_block(const Rows& r, const std::uint8_t* a_up, const std::uint8_t* b_up, std::uint32_t x,
                                 __m128i mask, CellLanes& s) {
  Block k = block_at(r, x);
  k.x1 = _mm_and_si128(k.x1, mask);
  k.x2 = _mm_and_si128(k.x2, mask);
  const Lanes lo = correlate<false>(k), hi = correlate<true>(k);
  s.mx = _mm256_add_epi32(s.mx, _mm256_add_epi32(lo.mx, hi.mx));
  s.my = _mm256_add_epi32(s.my, _mm256_add_epi32(lo.my, hi.my));
  const __m256i wide = _mm256_cvtepi8_epi16(mask);
  const __m256i gx =
      _mm256_and_si256(_mm256_sub_epi16(both(r.a + x + 1, r.b + x + 1), both(r.a + x - 1, r.b + x - 1)), wide);
  const __m256i gy =
      _mm256_and_si256(_mm256_sub_epi16(both(r.a_down + x, r.b_down + x), both(a_up + x, b_up + x)), wide);
  s.gxx = _mm256_add_epi32(s.gxx, _mm256_madd_epi16(gx, gx));
  s.gxy = _mm256_add_epi32(s.gxy, _mm256_madd_epi16(gx, gy));
  s.gyy = _mm256_add_epi32(s.gyy, _mm256_madd_epi16(gy, gy));
  s.older = _mm_add_epi64(s.older, _mm_sad_epu8(k.x1, _mm_setzero_si128()));
  s.newer = _mm_add_epi64(s.newer, _mm_sad_epu8(k.x2, _mm_setzero_si128()));
}

SINEW_AVX2_INLINE std::int64_t total(__m128i v) { return _mm_cvtsi128_si64(v) + _mm_extract_epi64(v, 1); }

}  // namespace

SINEW_AVX2 CellSums cell_avx2(const ImageView& older, const ImageView& newer, const PixelRect& cell) {
  const std::uint32_t width = cell.x1 - cell.x0, whole = cell.x0 + width / 16 * 16, last = cell.x1 - 16;
  const __m128i all = _mm_set1_epi8(-1), rest = all_but_first(whole - last);
  const __m256i zero = _mm256_setzero_si256();
  CellLanes s{zero, zero, zero, zero, zero, _mm_setzero_si128(), _mm_setzero_si128()};
  for (std::uint32_t y = cell.y0; y < cell.y1; ++y) {
    const Rows rows = rows_at(older, newer, y);
    const std::uint8_t *a_up = older.row(y - 1), *b_up = newer.row(y - 1);
    for (std::uint32_t x = cell.x0; x < whole; x += 16) add_block(rows, a_up, b_up, x, all, s);
    if (whole != cell.x1) add_block(rows, a_up, b_up, last, rest, s);
  }
  return {total(s.mx), total(s.my), total(s.gxx), total(s.gxy), total(s.gyy), total(s.older), total(s.newer)};
}

}  // namespace sinew::vision::detail
#endif
