#include "vision_floor.hpp"

#include <immintrin.h>

namespace sinew::bench::floor {
namespace {

struct Run {
  std::int16_t y, x0, x1;
  std::int32_t parent;
};
struct Blob {
  std::int32_t area, x0, y0, x1, y1;
  std::int64_t sum_x, sum_y;
};

struct Joiner {
  std::vector<Run> runs;
  std::vector<Blob> blobs;
  std::vector<std::int32_t> place;
  std::size_t before = 0, now = 0;

  void clear() { runs.clear(), before = now = 0; }
  std::int32_t root(std::int32_t i) {
    while (runs[i].parent != i) i = runs[i].parent = runs[runs[i].parent].parent;
    return i;
  }
  void add(int y, int x0, int x1) {
    runs.push_back({std::int16_t(y), std::int16_t(x0), std::int16_t(x1), std::int32_t(runs.size())});
  }
  void end_row() {
    for (std::size_t i = before, j = now; i < now && j < runs.size();) {
      if (runs[i].x1 >= runs[j].x0 && runs[j].x1 >= runs[i].x0) {
        const std::int32_t a = root(std::int32_t(i)), b = root(std::int32_t(j));
        if (a < b) runs[b].parent = a;
        if (b < a) runs[a].parent = b;
      }
      runs[i].x1 < runs[j].x1 ? ++i : ++j;
    }
    before = now, now = runs.size();
  }
  int finish(int min_area) {
    blobs.clear();
    place.assign(runs.size(), -1);
    for (std::size_t i = 0; i < runs.size(); ++i) {
      const std::int32_t r = root(std::int32_t(i));
      const Run& run = runs[i];
      if (place[r] < 0) {
        place[r] = std::int32_t(blobs.size());
        blobs.push_back({0, run.x0, run.y, 0, 0, 0, 0});
      }
      Blob& b = blobs[place[r]];
      const int n = run.x1 - run.x0;
      b.area += n;
      if (run.x0 < b.x0) b.x0 = run.x0;
      if (run.x1 > b.x1) b.x1 = run.x1;
      b.y1 = run.y;
      b.sum_x += (run.x0 + run.x1 - 1) * n / 2, b.sum_y += run.y * n;
    }
    int kept = 0;
    for (const Blob& b : blobs) kept += b.area >= min_area;
    return kept;
  }
};

std::array<Box, kColours> g_boxes;
std::vector<std::uint8_t> g_table;
Joiner g_joiner[kColours];

int finish(int min_area) {
  int n = 0;
  for (Joiner& j : g_joiner) n += j.finish(min_area);
  return n;
}

}  // namespace

void segmentation_setup(const std::array<Box, kColours>& boxes) {
  g_boxes = boxes;
  g_table.assign(64 * 64 * 32, 0);
  for (int v = 0; v < 64; ++v)
    for (int u = 0; u < 64; ++u)
      for (int y = 0; y < 32; ++y)
        for (int c = kColours - 1; c >= 0; --c) {
          const int q[3] = {y * 8 + 4, u * 4 + 2, v * 4 + 2};
          bool in = true;
          for (int k = 0; k < 3; ++k) in = in && q[k] >= boxes[c].lo[k] && q[k] <= boxes[c].hi[k];
          if (in) g_table[(v * 64 + u) * 32 + y] = std::uint8_t(c + 1);
        }
}

int segment_table(const std::uint8_t* yuyv, int min_area) {
  for (Joiner& j : g_joiner) j.clear();
  for (int y = 0; y < kHeight; ++y) {
    const std::uint8_t* p = yuyv + y * kWidth * 2;
    int colour = 0, from = 0;
    for (int x = 0; x < kWidth; x += 2, p += 4) {
      const std::uint8_t* cell = &g_table[((p[3] >> 2) * 64 + (p[1] >> 2)) * 32];
      for (int k = 0; k < 2; ++k)
        if (const int c = cell[p[2 * k] >> 3]; c != colour) {
          if (colour) g_joiner[colour - 1].add(y, from, x + k);
          colour = c, from = x + k;
        }
    }
    if (colour) g_joiner[colour - 1].add(y, from, kWidth);
    for (Joiner& j : g_joiner) j.end_row();
  }
  return finish(min_area);
}

int segment_boxes(const std::uint8_t* yuyv, int min_area) {
  for (Joiner& j : g_joiner) j.clear();
  __m256i lo[kColours][3], span[kColours][3];
  for (int c = 0; c < kColours; ++c)
    for (int k = 0; k < 3; ++k) {
      lo[c][k] = _mm256_set1_epi8(char(g_boxes[c].lo[k]));
      span[c][k] = _mm256_set1_epi8(char(g_boxes[c].hi[k] - g_boxes[c].lo[k]));
    }
  const __m256i pick_yu =
      _mm256_broadcastsi128_si256(_mm_setr_epi8(0, 2, 4, 6, 8, 10, 12, 14, 1, 1, 5, 5, 9, 9, 13, 13));
  const __m256i pick_v =
      _mm256_broadcastsi128_si256(_mm_setr_epi8(3, 3, 7, 7, 11, 11, 15, 15, 3, 3, 7, 7, 11, 11, 15, 15));
  for (int y = 0; y < kHeight; ++y) {
    const std::uint8_t* p = yuyv + y * kWidth * 2;
    std::uint32_t carry[kColours] = {};
    int from[kColours] = {};
    for (int x = 0; x < kWidth; x += 32, p += 64) {
      const __m256i r0 = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p));
      const __m256i r1 = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p + 32));
      const __m256i a0 = _mm256_shuffle_epi8(r0, pick_yu), a1 = _mm256_shuffle_epi8(r1, pick_yu);
      const __m256i py = _mm256_permute4x64_epi64(_mm256_unpacklo_epi64(a0, a1), 0xD8);
      const __m256i pu = _mm256_permute4x64_epi64(_mm256_unpackhi_epi64(a0, a1), 0xD8);
      const __m256i pv = _mm256_permute4x64_epi64(
          _mm256_unpacklo_epi64(_mm256_shuffle_epi8(r0, pick_v), _mm256_shuffle_epi8(r1, pick_v)), 0xD8);
      for (int c = 0; c < kColours; ++c) {
        __m256i out = _mm256_subs_epu8(_mm256_sub_epi8(py, lo[c][0]), span[c][0]);
        out = _mm256_or_si256(out, _mm256_subs_epu8(_mm256_sub_epi8(pu, lo[c][1]), span[c][1]));
        out = _mm256_or_si256(out, _mm256_subs_epu8(_mm256_sub_epi8(pv, lo[c][2]), span[c][2]));
        const auto mask = std::uint32_t(_mm256_movemask_epi8(_mm256_cmpeq_epi8(out, _mm256_setzero_si256())));
        std::uint32_t edge = mask ^ ((mask << 1) | carry[c]);
        carry[c] = mask >> 31;
        for (; edge; edge &= edge - 1) {
          const int bit = __builtin_ctz(edge);
          if ((mask >> bit) & 1)
            from[c] = x + bit;
          else
            g_joiner[c].add(y, from[c], x + bit);
        }
      }
    }
    for (int c = 0; c < kColours; ++c) {
      if (carry[c]) g_joiner[c].add(y, from[c], kWidth);
      g_joiner[c].end_row();
    }
  }
  return finish(min_area);
}

namespace {

__m128i load(const std::uint8_t* p) { return _mm_loadu_si128(reinterpret_cast<const __m128i*>(p)); }

// Odd polynomial of degree 7 on [0, 1], evaluated with FMA.
__m256 atan2_of(__m256 y, __m256 x) {
  const __m256 sign = _mm256_set1_ps(-0.0f);
  const __m256 ay = _mm256_andnot_ps(sign, y), ax = _mm256_andnot_ps(sign, x);
  const __m256 a = _mm256_div_ps(_mm256_min_ps(ax, ay), _mm256_max_ps(_mm256_max_ps(ax, ay), _mm256_set1_ps(1e-20f)));
  const __m256 s = _mm256_mul_ps(a, a);
  __m256 r = _mm256_fmadd_ps(s, _mm256_set1_ps(-0.0438129492f), _mm256_set1_ps(0.155316204f));
  r = _mm256_fmadd_ps(r, s, _mm256_set1_ps(-0.326238215f));
  r = _mm256_fmadd_ps(_mm256_mul_ps(r, s), a, a);
  r = _mm256_blendv_ps(r, _mm256_sub_ps(_mm256_set1_ps(1.57079637f), r), _mm256_cmp_ps(ay, ax, _CMP_GT_OQ));
  r = _mm256_blendv_ps(r, _mm256_sub_ps(_mm256_set1_ps(3.14159274f), r), x);
  return _mm256_or_ps(r, _mm256_and_ps(y, sign));
}

template <bool kPolar>
void emd(const std::uint8_t* f1, const std::uint8_t* f2, float* magnitude, float* direction, std::int64_t* sums) {
  const __m256i plus_minus = _mm256_set1_epi32(int(0xffff0001u));
  __m256i sx = _mm256_setzero_si256(), sy = sx;
  for (int y = 0; y < kHeight - 1; ++y)
    for (int x = 0; x < kWidth; x += 16) {
      const std::uint8_t *a = f1 + y * kWidth + x, *b = f2 + y * kWidth + x;
      const __m128i x1 = load(a), x2 = load(b), r1 = load(a + 1), r2 = load(b + 1);
      const __m128i d1 = load(a + kWidth), d2 = load(b + kWidth);
      for (int h = 0; h < 2; ++h) {
        const auto pairs = [h](__m128i p, __m128i q) {
          return _mm256_cvtepu8_epi16(h ? _mm_unpackhi_epi8(p, q) : _mm_unpacklo_epi8(p, q));
        };
        const __m256i base = _mm256_sign_epi16(pairs(x2, x1), plus_minus);
        const __m256i mx = _mm256_madd_epi16(base, pairs(r1, r2)), my = _mm256_madd_epi16(base, pairs(d1, d2));
        if (kPolar) {
          const __m256 fx = _mm256_cvtepi32_ps(mx), fy = _mm256_cvtepi32_ps(my);
          const int at = y * kWidth + x + h * 8;
          _mm256_storeu_ps(magnitude + at, _mm256_sqrt_ps(_mm256_fmadd_ps(fx, fx, _mm256_mul_ps(fy, fy))));
          _mm256_storeu_ps(direction + at, atan2_of(fy, fx));
        } else {
          sx = _mm256_add_epi32(sx, mx), sy = _mm256_add_epi32(sy, my);
        }
      }
    }
  if (!kPolar) {
    alignas(32) std::int32_t v[16];
    _mm256_store_si256(reinterpret_cast<__m256i*>(v), sx);
    _mm256_store_si256(reinterpret_cast<__m256i*>(v + 8), sy);
    sums[0] = sums[1] = 0;
    for (int i = 0; i < 8; ++i) sums[0] += v[i], sums[1] += v[8 + i];
  }
}

}  // namespace

void emd_polar(const std::uint8_t* older, const std::uint8_t* newer, float* magnitude, float* direction) {
  emd<true>(older, newer, magnitude, direction, nullptr);
}
void emd_sums(const std::uint8_t* older, const std::uint8_t* newer, std::int64_t* sums) {
  emd<false>(older, newer, nullptr, nullptr, sums);
}

namespace {

/// Sums of four rows at 16 columns, as 16-bit numbers; of mono8 each the sum of two columns.
template <bool kYuyv>
__m256i column_sums(const std::uint8_t* p, int stride) {
  __m256i sum = _mm256_setzero_si256();
  for (int i = 0; i < 4; ++i, p += stride) {
    const __m256i v = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p));
    sum = _mm256_add_epi16(
        sum, kYuyv ? _mm256_and_si256(v, _mm256_set1_epi16(0xff)) : _mm256_maddubs_epi16(v, _mm256_set1_epi8(1)));
  }
  return sum;
}

/// 32 results at a time: each 32 bytes of mono8 are eight of them, of yuyv four.
template <bool kYuyv>
void bin4(const std::uint8_t* in, std::uint8_t* out) {
  constexpr int kPixel = kYuyv ? 2 : 1, kStride = kWidth * kPixel;
  const __m256i ones = _mm256_set1_epi16(1), half = _mm256_set1_epi32(8);
  const __m256i in_order = _mm256_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7);
  for (int y = 0; y < kHeight; y += 4, in += 4 * kStride)
    for (int x = 0; x < kStride; x += 4 * 32 * kPixel, out += 32) {
      __m256i eight[4];
      for (int k = 0; k < 4; ++k) {
        const std::uint8_t* p = in + x + 32 * kPixel * k;
        __m256i sum = _mm256_madd_epi16(column_sums<kYuyv>(p, kStride), ones);
        if (kYuyv) {
          sum = _mm256_hadd_epi32(sum, _mm256_madd_epi16(column_sums<kYuyv>(p + 32, kStride), ones));
          sum = _mm256_permute4x64_epi64(sum, 0xD8);
        }
        eight[k] = _mm256_srli_epi32(_mm256_add_epi32(sum, half), 4);
      }
      const __m256i a = _mm256_packs_epi32(eight[0], eight[1]), b = _mm256_packs_epi32(eight[2], eight[3]);
      const __m256i bytes = _mm256_permutevar8x32_epi32(_mm256_packus_epi16(a, b), in_order);
      _mm256_storeu_si256(reinterpret_cast<__m256i*>(out), bytes);
    }
}

}  // namespace

void bin4_yuyv(const std::uint8_t* yuyv, std::uint8_t* out) { bin4<true>(yuyv, out); }
void bin4_mono(const std::uint8_t* mono, std::uint8_t* out) { bin4<false>(mono, out); }

}  // namespace sinew::bench::floor
