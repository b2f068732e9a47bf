// The box thresholds on 32 pixels a step. Integers only: exactly the runs of the scalar kernel.
#include <cstring>

#include "vision/mask_runs.hpp"
#include "vision/segmentation.hpp"

#ifdef SINEW_VISION_NEON
#include <arm_neon.h>

namespace sinew::vision::detail {
namespace {

/// Thresholds as unsigned distance from `lo`; nothing is inside when lo > hi.
struct BoxLanes {
  uint8x16_t lo[3], span[3];
  std::uint32_t possible = ~0u;
};

inline uint8x16_t within(uint8x16_t value, const BoxLanes& b, int k) {
  return vcleq_u8(vsubq_u8(value, b.lo[k]), b.span[k]);
}

/// One bit per pixel: inside the box. `p` holds 16 times y0 u y1 v.
inline std::uint32_t inside(const uint8x16x4_t& p, const BoxLanes& b) {
  const uint8_t weights[16] = {1, 2, 4, 8, 16, 32, 64, 128, 1, 2, 4, 8, 16, 32, 64, 128};
  const uint8x16_t weight = vld1q_u8(weights), uv = vandq_u8(within(p.val[1], b, 1), within(p.val[3], b, 2));
  const uint8x16_t even = vandq_u8(uv, within(p.val[0], b, 0)), odd = vandq_u8(uv, within(p.val[2], b, 0));
  const uint8x16_t first = vandq_u8(vzip1q_u8(even, odd), weight), second = vandq_u8(vzip2q_u8(even, odd), weight);
  const uint8x16_t pairs = vpaddq_u8(first, second), fours = vpaddq_u8(pairs, pairs), eights = vpaddq_u8(fours, fours);
  return vgetq_lane_u32(vreinterpretq_u32_u8(eights), 0);
}

}  // namespace

void box_runs_neon(const ImageView& image, std::span<const ColourBox> boxes, RunJoiner* joiners) {
  BoxLanes lanes[kMaxColours];
  const std::size_t n = boxes.size();
  for (std::size_t c = 0; c < n; ++c)
    for (int k = 0; k < 3; ++k) {
      const std::uint8_t lo = boxes[c].lo[k], hi = boxes[c].hi[k];
      if (lo > hi) lanes[c].possible = 0;
      lanes[c].lo[k] = vdupq_n_u8(lo);
      lanes[c].span[k] = vdupq_n_u8(static_cast<std::uint8_t>(hi - lo));
    }
  const std::uint32_t whole = image.width / 32 * 32, rest = image.width - whole;
  for (std::uint32_t y = 0; y < image.height; ++y) {
    const std::uint8_t* p = image.row(y);
    MaskRow state[kMaxColours];
    for (std::uint32_t x = 0; x < whole; x += 32, p += 64) {
      const uint8x16x4_t block = vld4q_u8(p);
      for (std::size_t c = 0; c < n; ++c)
        add_mask(inside(block, lanes[c]) & lanes[c].possible, y, x, state[c], joiners[c]);
    }
    if (rest != 0) {
      std::uint8_t padded[64] = {};
      std::memcpy(padded, p, std::size_t{rest} * 2);
      const uint8x16x4_t block = vld4q_u8(padded);
      const std::uint32_t valid = (1u << rest) - 1;
      for (std::size_t c = 0; c < n; ++c)
        add_mask(inside(block, lanes[c]) & lanes[c].possible & valid, y, whole, state[c], joiners[c]);
    }
    for (std::size_t c = 0; c < n; ++c) {
      if (state[c].carry != 0) joiners[c].add(y, state[c].from, image.width);
      joiners[c].end_row();
    }
  }
}

}  // namespace sinew::vision::detail
#endif
