#pragma once
// The pixels of a candidate as the ball classifier sees them.
#include <array>

#include "soccer/sight/ball_candidates.hpp"

namespace sinew::soccer {

/// Shape:   16 x 16 of luma, then 8 x 8 of u and 8 x 8 of v, row by row; a square of three radii a side round the
/// middle. Units:   luma: of the patch's mean, in its standard deviations. Chroma: shares of luma, of the carpet's,
/// times 2.5.
struct BallPatch {
  static constexpr std::size_t kSide = 16, kChromaSide = 8;
  static constexpr std::size_t kValues = kSide * kSide + 2 * kChromaSide * kChromaSide;
  std::array<float, kValues> value{};
};

/// What is beyond the picture repeats its edge.   RT: yes.
void take_patch(const Picture& picture, const CarpetLook& carpet, const BallCandidate& ball, BallPatch& out);

}  // namespace sinew::soccer
