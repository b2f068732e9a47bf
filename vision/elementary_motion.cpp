#include "vision/elementary_motion.hpp"

#include "math/elementary.hpp"

namespace sinew::vision {

void correlate_polar(const ImageView& older, const ImageView& newer, float* magnitude, float* direction_rad,
                     Simd simd) {
#if defined(SINEW_VISION_AVX2)
  if (simd == Simd::avx2) return detail::polar_avx2(older, newer, magnitude, direction_rad);
#elif defined(SINEW_VISION_NEON)
  if (simd == Simd::neon) return detail::polar_neon(older, newer, magnitude, direction_rad);
#endif
  (void)simd;
  detail::polar_scalar(older, newer, magnitude, direction_rad);
}

CorrelatorSums correlate_sums(const ImageView& older, const ImageView& newer, Simd simd) {
#if defined(SINEW_VISION_AVX2)
  if (simd == Simd::avx2) return detail::sums_avx2(older, newer);
#elif defined(SINEW_VISION_NEON)
  if (simd == Simd::neon) return detail::sums_neon(older, newer);
#endif
  (void)simd;
  return detail::sums_scalar(older, newer);
}

CellSums correlate_cell(const ImageView& older, const ImageView& newer, const PixelRect& cell, Simd simd) {
#if defined(SINEW_VISION_AVX2)
  if (simd == Simd::avx2 && cell.x1 - cell.x0 >= 16) return detail::cell_avx2(older, newer, cell);
#elif defined(SINEW_VISION_NEON)
  if (simd == Simd::neon && cell.x1 - cell.x0 >= 16) return detail::cell_neon(older, newer, cell);
#endif
  (void)simd;
  return detail::cell_scalar(older, newer, cell);
}

namespace detail {
namespace {

struct Correlation {
  int x, y;
};

Correlation correlate(const std::uint8_t* x1, const std::uint8_t* x2, const std::uint8_t* x1_down,
                      const std::uint8_t* x2_down) {
  return {x2[0] * x1[1] - x1[0] * x2[1], x2[0] * x1_down[0] - x1[0] * x2_down[0]};
}

struct Polar {
  float magnitude, direction_rad;
};

Polar polar(const Correlation& m) {
  const int ax = m.x < 0 ? -m.x : m.x, ay = m.y < 0 ? -m.y : m.y;
  const bool steep = ay > ax;
  const float small = static_cast<float>(steep ? ax : ay),
              large = static_cast<float>(steep ? ay : ax);  // exact: < 2^17
  const float a = small / (large > kTiny ? large : kTiny), s = a * a, cube = a * s;
  const float first = a + cube * kAtan0, rest = kAtan2 * s + kAtan1;
  float r = first + (cube * s) * rest;
  if (steep) r = kHalfPi - r;
  if (m.x < 0) r = kPi - r;
  return {math::sqrt(large * large + small * small), m.y < 0 ? -r : r};
}

}  // namespace

void polar_scalar(const ImageView& older, const ImageView& newer, float* magnitude, float* direction_rad) {
  for (std::uint32_t y = 0; y + 1 < older.height; ++y) {
    const std::uint8_t *a = older.row(y), *b = newer.row(y), *a_down = older.row(y + 1), *b_down = newer.row(y + 1);
    float* const mag = magnitude + std::size_t{y} * older.width;
    float* const dir = direction_rad + std::size_t{y} * older.width;
    for (std::uint32_t x = 0; x + 1 < older.width; ++x) {
      const Polar p = polar(correlate(a + x, b + x, a_down + x, b_down + x));
      mag[x] = p.magnitude;
      dir[x] = p.direction_rad;
    }
  }
}

CorrelatorSums sums_scalar(const ImageView& older, const ImageView& newer) {
  CorrelatorSums sums;
  for (std::uint32_t y = 0; y + 1 < older.height; ++y) {
    const std::uint8_t *a = older.row(y), *b = newer.row(y), *a_down = older.row(y + 1), *b_down = newer.row(y + 1);
    for (std::uint32_t x = 0; x + 1 < older.width; ++x) {
      const Correlation m = correlate(a + x, b + x, a_down + x, b_down + x);
      sums.x += m.x;
      sums.y += m.y;
    }
  }
  return sums;
}

CellSums cell_scalar(const ImageView& older, const ImageView& newer, const PixelRect& cell) {
  CellSums sums;
  for (std::uint32_t y = cell.y0; y < cell.y1; ++y) {
    const std::uint8_t *a = older.row(y), *a_up = older.row(y - 1), *a_down = older.row(y + 1);
    const std::uint8_t *b = newer.row(y), *b_up = newer.row(y - 1), *b_down = newer.row(y + 1);
    for (std::uint32_t x = cell.x0; x < cell.x1; ++x) {
      const Correlation m = correlate(a + x, b + x, a_down + x, b_down + x);
      const int gx = (a[x + 1] + b[x + 1]) - (a[x - 1] + b[x - 1]);
      const int gy = (a_down[x] + b_down[x]) - (a_up[x] + b_up[x]);
      sums.mx += m.x;
      sums.my += m.y;
      sums.gxx += gx * gx;
      sums.gxy += gx * gy;
      sums.gyy += gy * gy;
      sums.older += a[x];
      sums.newer += b[x];
    }
  }
  return sums;
}

}  // namespace detail

}  // namespace sinew::vision
