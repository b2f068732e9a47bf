#pragma once
#include <cstdint>

#include "vision/image_view.hpp"
#include "vision/simd.hpp"

namespace sinew::vision {

// Elementary motion detection: each pixel and its neighbour are correlated over two consecutive frames, the delayed one
// of either with the present other one. With x1 the older and x2 the newer frame, s the shift by one pixel:
//   (1) Mx = x2 * s_right(x1) - x1 * s_right(x2)      (2) My = x2 * s_down(x1) - x1 * s_down(x2)
//   (3) magnitude = sqrt(Mx^2 + My^2)                 (4) direction = atan2(My, Mx)
// A pattern that moves right (down) gives negative Mx (My). A change of brightness by a factor gives exactly 0.
// Source:  B. Hassenstein, W. Reichardt, Z. Naturforsch. 11b (1956) 513, as altURI's equations 1-4.
//
// Frames are mono8 views of equal size, at least 2 x 2. Scalar and SIMD give the same bits: integers up to Mx and My,
// then IEEE operations in one order, without FMA.
// Thread:  any.   RT: yes.

/// All four equations at every pixel. Direction by a polynomial, within 2e-4 rad of atan2.
/// Shape:   outputs are height rows of `width` floats; the last row and the last column have no neighbour and stay
///          untouched.
void correlate_polar(const ImageView& older, const ImageView& newer, float* magnitude, float* direction_rad,
                     Simd simd = best_simd());

struct CorrelatorSums {
  std::int64_t x = 0, y = 0;
  friend bool operator==(const CorrelatorSums&, const CorrelatorSums&) = default;
};
/// Sums of Mx and My over all pixels that have both neighbours.
CorrelatorSums correlate_sums(const ImageView& older, const ImageView& newer, Simd simd = best_simd());

/// Pixels x0 <= x < x1, y0 <= y < y1.
struct PixelRect {
  std::uint32_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

inline constexpr std::uint32_t kMaxCell = 128;  // pixels a side; keeps 32-bit lanes from overflowing

/// The sums of one cell, for its motion. With s the sum of both frames and g the central difference s(+1) - s(-1):
struct CellSums {
  std::int64_t mx = 0, my = 0;             // equations 1 and 2, summed
  std::int64_t gxx = 0, gxy = 0, gyy = 0;  // products of g
  std::int64_t older = 0, newer = 0;       // grey values
  friend bool operator==(const CellSums&, const CellSums&) = default;
};
/// The rectangle lies within columns 1..width-2 and rows 1..height-2 (one pixel of border is read) and is at most
/// kMaxCell a side.
CellSums correlate_cell(const ImageView& older, const ImageView& newer, const PixelRect& cell, Simd simd = best_simd());

namespace detail {
void polar_scalar(const ImageView& older, const ImageView& newer, float* magnitude, float* direction_rad);
void polar_avx2(const ImageView& older, const ImageView& newer, float* magnitude, float* direction_rad);
void polar_neon(const ImageView& older, const ImageView& newer, float* magnitude, float* direction_rad);
CorrelatorSums sums_scalar(const ImageView& older, const ImageView& newer);
CorrelatorSums sums_avx2(const ImageView& older, const ImageView& newer);
CorrelatorSums sums_neon(const ImageView& older, const ImageView& newer);
CellSums cell_scalar(const ImageView& older, const ImageView& newer, const PixelRect& cell);
CellSums cell_avx2(const ImageView& older, const ImageView& newer, const PixelRect& cell);
CellSums cell_neon(const ImageView& older, const ImageView& newer, const PixelRect& cell);

// atan on [0, 1] as an odd polynomial a + a^3 (c0 + c1 a^2 + c2 a^4), least maximal error for this degree.
// Source:  Remez fit by tools/fit_atan.py; largest error 1.4e-4 rad.
inline constexpr float kAtan0 = -0.326238215f, kAtan1 = 0.155316204f, kAtan2 = -0.0438129492f;
inline constexpr float kHalfPi = 1.57079637f, kPi = 3.14159274f;
inline constexpr float kTiny = 1e-20f;  // instead of 0 / 0 where nothing moves; far below the least magnitude, 1
}  // namespace detail

}  // namespace sinew::vision
