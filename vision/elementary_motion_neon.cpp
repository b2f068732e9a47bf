// Elementary motion detection on 16 pixels a step, 8 where every pixel gets a result: products of bytes have 16 bits,
// their differences 32.
#include "vision/elementary_motion.hpp"

#ifdef SINEW_VISION_NEON
#include <arm_neon.h>

namespace sinew::vision::detail {
namespace {

struct Rows {
  const std::uint8_t *a, *b, *a_down, *b_down;
};

inline Rows rows_at(const ImageView& older, const ImageView& newer, std::uint32_t y) {
  return {older.row(y), newer.row(y), older.row(y + 1), newer.row(y + 1)};
}

/// Adds x2 x1' - x1 x2' of 16 pixels.
inline int32x4_t correlate(int32x4_t sum, uint8x16_t x1, uint8x16_t x2, uint8x16_t x1_next, uint8x16_t x2_next) {
  uint32x4_t s = vreinterpretq_u32_s32(sum);  // may be below 0 for a moment, which does not matter modulo 2^32
  const uint16x8_t plus = vmull_u8(vget_low_u8(x2), vget_low_u8(x1_next)), plus_high = vmull_high_u8(x2, x1_next);
  const uint16x8_t minus = vmull_u8(vget_low_u8(x1), vget_low_u8(x2_next)), minus_high = vmull_high_u8(x1, x2_next);
  s = vaddw_high_u16(vaddw_u16(s, vget_low_u16(plus)), plus);
  s = vaddw_high_u16(vaddw_u16(s, vget_low_u16(plus_high)), plus_high);
  s = vsubw_high_u16(vsubw_u16(s, vget_low_u16(minus)), minus);
  s = vsubw_high_u16(vsubw_u16(s, vget_low_u16(minus_high)), minus_high);
  return vreinterpretq_s32_u32(s);
}

/// Bytes `skip`..15 set: the pixels of the last, overlapping block that were not counted yet.
inline uint8x16_t all_but_first(std::uint32_t skip) {
  const uint8_t index[16] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  return vcgeq_u8(vld1q_u8(index), vdupq_n_u8(static_cast<std::uint8_t>(skip)));
}

/// Equations 3 and 4 for four pixels; the same operations in the same order as polar() in elementary_motion.cpp.
inline void store_polar(int32x4_t mx, int32x4_t my, float* magnitude, float* direction_rad) {
  const int32x4_t ax = vabsq_s32(mx), ay = vabsq_s32(my);
  const float32x4_t small = vcvtq_f32_s32(vminq_s32(ax, ay)), large = vcvtq_f32_s32(vmaxq_s32(ax, ay));
  vst1q_f32(magnitude, vsqrtq_f32(vaddq_f32(vmulq_f32(large, large), vmulq_f32(small, small))));
  const float32x4_t a = vdivq_f32(small, vmaxq_f32(large, vdupq_n_f32(kTiny)));
  const float32x4_t s = vmulq_f32(a, a), cube = vmulq_f32(a, s);
  const float32x4_t first = vaddq_f32(a, vmulq_f32(cube, vdupq_n_f32(kAtan0)));
  const float32x4_t rest = vaddq_f32(vmulq_f32(vdupq_n_f32(kAtan2), s), vdupq_n_f32(kAtan1));
  float32x4_t r = vaddq_f32(first, vmulq_f32(vmulq_f32(cube, s), rest));
  r = vbslq_f32(vcgtq_s32(ay, ax), vsubq_f32(vdupq_n_f32(kHalfPi), r), r);
  r = vbslq_f32(vcltzq_s32(mx), vsubq_f32(vdupq_n_f32(kPi), r), r);
  vst1q_f32(direction_rad, vbslq_f32(vcltzq_s32(my), vnegq_f32(r), r));
}

struct Eight {
  int32x4_t low, high;
};

/// x2 x1' - x1 x2' of eight pixels.
inline Eight correlate(uint8x8_t x1, uint8x8_t x2, uint8x8_t x1_next, uint8x8_t x2_next) {
  const uint16x8_t plus = vmull_u8(x2, x1_next), minus = vmull_u8(x1, x2_next);
  return {vreinterpretq_s32_u32(vsubl_u16(vget_low_u16(plus), vget_low_u16(minus))),
          vreinterpretq_s32_u32(vsubl_high_u16(plus, minus))};
}

}  // namespace

void polar_neon(const ImageView& older, const ImageView& newer, float* magnitude, float* direction_rad) {
  const std::uint32_t width = older.width, valid = width - 1;  // pixels of a row that have a right neighbour
  if (valid < 8) return polar_scalar(older, newer, magnitude, direction_rad);
  for (std::uint32_t y = 0; y + 1 < older.height; ++y) {
    const Rows r = rows_at(older, newer, y);
    float* const mag = magnitude + std::size_t{y} * width;
    float* const dir = direction_rad + std::size_t{y} * width;
    for (std::uint32_t x = 0;; x = x + 16 <= valid ? x + 8 : valid - 8) {  // the last block overlaps the one before
      const uint8x8_t x1 = vld1_u8(r.a + x), x2 = vld1_u8(r.b + x);
      const Eight mx = correlate(x1, x2, vld1_u8(r.a + x + 1), vld1_u8(r.b + x + 1));
      const Eight my = correlate(x1, x2, vld1_u8(r.a_down + x), vld1_u8(r.b_down + x));
      store_polar(mx.low, my.low, mag + x, dir + x);
      store_polar(mx.high, my.high, mag + x + 4, dir + x + 4);
      if (x + 8 == valid) break;
    }
  }
}

namespace {

struct SumLanes {
  int32x4_t mx, my;
};

/// `mask` chooses the pixels of the block that count.
inline void add_block(const Rows& r, std::uint32_t x, uint8x16_t mask, SumLanes& s) {
  const uint8x16_t x1 = vandq_u8(vld1q_u8(r.a + x), mask), x2 = vandq_u8(vld1q_u8(r.b + x), mask);
  s.mx = correlate(s.mx, x1, x2, vld1q_u8(r.a + x + 1), vld1q_u8(r.b + x + 1));
  s.my = correlate(s.my, x1, x2, vld1q_u8(r.a_down + x), vld1q_u8(r.b_down + x));
}

}  // namespace

CorrelatorSums sums_neon(const ImageView& older, const ImageView& newer) {
  const std::uint32_t valid = older.width - 1;
  if (valid < 16 || older.width > msg::kMaxImageWidth) return sums_scalar(older, newer);
  const std::uint32_t whole = valid / 16 * 16, last = valid - 16;
  const uint8x16_t all = vdupq_n_u8(0xff), rest = all_but_first(whole - last);
  int64x2_t x_sum = vdupq_n_s64(0), y_sum = x_sum;
  for (std::uint32_t y = 0; y + 1 < older.height; ++y) {
    const Rows rows = rows_at(older, newer, y);
    SumLanes s{vdupq_n_s32(0), vdupq_n_s32(0)};  // 4 * 80 additions of 255^2 a row: far from 2^31
    for (std::uint32_t x = 0; x < whole; x += 16) add_block(rows, x, all, s);
    if (whole != valid) add_block(rows, last, rest, s);
    x_sum = vpadalq_s32(x_sum, s.mx);
    y_sum = vpadalq_s32(y_sum, s.my);
  }
  return {vaddvq_s64(x_sum), vaddvq_s64(y_sum)};
}

namespace {

struct CellLanes {  // 128 rows of 8 blocks of 4 additions of 510^2: below 2^31
  SumLanes m;
  int32x4_t gxx, gxy, gyy;
  uint32x4_t older, newer;
};

struct Gradient {
  int16x8_t low, high;
};

/// The sum of both frames here minus that there, where the mask is set.
inline Gradient difference(const std::uint8_t* a, const std::uint8_t* b, const std::uint8_t* a_from,
                           const std::uint8_t* b_from, uint8x16_t mask) {
  const uint8x16_t p = vld1q_u8(a), q = vld1q_u8(b), p_from = vld1q_u8(a_from), q_from = vld1q_u8(b_from);
  const uint16x8_t low =
      vsubq_u16(vaddl_u8(vget_low_u8(p), vget_low_u8(q)), vaddl_u8(vget_low_u8(p_from), vget_low_u8(q_from)));
  const uint16x8_t high = vsubq_u16(vaddl_high_u8(p, q), vaddl_high_u8(p_from, q_from));
  const int8x16_t wide = vreinterpretq_s8_u8(mask);
  return {vandq_s16(vreinterpretq_s16_u16(low), vmovl_s8(vget_low_s8(wide))),
          vandq_s16(vreinterpretq_s16_u16(high), vmovl_high_s8(wide))};
}

inline int32x4_t add_products(int32x4_t sum, const Gradient& g, const Gradient& h) {
  sum = vmlal_high_s16(vmlal_s16(sum, vget_low_s16(g.low), vget_low_s16(h.low)), g.low, h.low);
  return vmlal_high_s16(vmlal_s16(sum, vget_low_s16(g.high), vget_low_s16(h.high)), g.high, h.high);
}

inline void add_block(const Rows& r, const std::uint8_t* a_up, const std::uint8_t* b_up, std::uint32_t x,
                      uint8x16_t mask, CellLanes& s) {
  add_block(r, x, mask, s.m);
  const Gradient gx = difference(r.a + x + 1, r.b + x + 1, r.a + x - 1, r.b + x - 1, mask);
  const Gradient gy = difference(r.a_down + x, r.b_down + x, a_up + x, b_up + x, mask);
  s.gxx = add_products(s.gxx, gx, gx);
  s.gxy = add_products(s.gxy, gx, gy);
  s.gyy = add_products(s.gyy, gy, gy);
  s.older = vpadalq_u16(s.older, vpaddlq_u8(vandq_u8(vld1q_u8(r.a + x), mask)));
  s.newer = vpadalq_u16(s.newer, vpaddlq_u8(vandq_u8(vld1q_u8(r.b + x), mask)));
}

}  // namespace

CellSums cell_neon(const ImageView& older, const ImageView& newer, const PixelRect& cell) {
  const std::uint32_t width = cell.x1 - cell.x0, whole = cell.x0 + width / 16 * 16, last = cell.x1 - 16;
  const uint8x16_t all = vdupq_n_u8(0xff), rest = all_but_first(whole - last);
  const int32x4_t zero = vdupq_n_s32(0);
  CellLanes s{{zero, zero}, zero, zero, zero, vdupq_n_u32(0), vdupq_n_u32(0)};
  for (std::uint32_t y = cell.y0; y < cell.y1; ++y) {
    const Rows rows = rows_at(older, newer, y);
    const std::uint8_t *a_up = older.row(y - 1), *b_up = newer.row(y - 1);
    for (std::uint32_t x = cell.x0; x < whole; x += 16) add_block(rows, a_up, b_up, x, all, s);
    if (whole != cell.x1) add_block(rows, a_up, b_up, last, rest, s);
  }
  const auto sum = [](uint32x4_t v) { return static_cast<std::int64_t>(vaddlvq_u32(v)); };
  return {vaddlvq_s32(s.m.mx), vaddlvq_s32(s.m.my), vaddlvq_s32(s.gxx), vaddlvq_s32(s.gxy),
          vaddlvq_s32(s.gyy),  sum(s.older),        sum(s.newer)};
}

}  // namespace sinew::vision::detail
#endif
