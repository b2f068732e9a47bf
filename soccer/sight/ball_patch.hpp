#pragma once
// The pixels of a candidate as the ball classifier sees them.
#include <array>

#include "soccer/sight/ball_candidates.hpp"

namespace sinew::soccer {

/// Shape:   16 x 16 of luma, then 8 x 8 of u and 8 x 8 of v, row by row, of a square of `kAcross` radii a side round
///          the middle; then four facts: fit, size against the expected one, expected size, share beyond the picture.
/// Units:   luma: of the patch's mean, in its standard deviations. Chroma: shares of luma, of the carpet's,
///          times 2.5. Facts: about -1 to 1.
struct BallPatch {
  static constexpr std::size_t kSide = 16, kChromaSide = 8, kFacts = 4;
  static constexpr std::size_t kLuma = kSide * kSide, kChroma = kChromaSide * kChromaSide;
  static constexpr std::size_t kValues = kLuma + 2 * kChroma + kFacts;
  static constexpr double kAcross = 3.6;
  std::array<float, kValues> value{};
};

/// What is beyond the picture repeats its edge.   RT: yes.
void take_patch(const Picture& picture, const CarpetLook& carpet, const BallCandidate& ball, BallPatch& out);

}  // namespace sinew::soccer
