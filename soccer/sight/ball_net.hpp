#pragma once
// A small network that says whether a patch shows a ball.
#include <span>

#include "soccer/sight/ball_patch.hpp"

namespace sinew::soccer {

/// Two layers of 3 x 3 filters, each with the largest of 2 x 2 places and rectified; a layer of units that also sees
/// the patch's facts; a logistic output. Sums run in the order of the inputs, each unit on its own: the same bytes on
/// every machine.
/// Source:  Y. LeCun et al., Gradient-based learning applied to document recognition, Proc. IEEE 86 (1998).
/// Thread:  any.   RT: yes.
class BallNet {
 public:
  static constexpr std::size_t kFirst = 8, kSecond = 16, kUnits = 24;  // filters, filters, units
  static constexpr std::size_t kTaps = 9;
  static constexpr std::size_t kPool1 = BallPatch::kSide / 2;  // a side of what the first layer gives
  static constexpr std::size_t kDeep = kFirst + 2;             // with u and v beside it
  static constexpr std::size_t kSide2 = kPool1 - 2, kPool2 = kSide2 / 2;
  static constexpr std::size_t kFlat = kPool2 * kPool2 * kSecond + BallPatch::kFacts;
  static_assert(kPool1 == BallPatch::kChromaSide && kFirst % 4 == 0 && kSecond % 4 == 0 && kUnits % 4 == 0);

  // Where each layer's weights begin: for each input (of filters: for each tap, row by row, then for each input) the
  // weights to all units, then their offsets.
  static constexpr std::size_t kAt1 = 0, kOffset1 = kAt1 + kTaps * kFirst;
  static constexpr std::size_t kAt2 = kOffset1 + kFirst, kOffset2 = kAt2 + kTaps * kDeep * kSecond;
  static constexpr std::size_t kAt3 = kOffset2 + kSecond, kOffset3 = kAt3 + kFlat * kUnits;
  static constexpr std::size_t kAt4 = kOffset3 + kUnits, kOffset4 = kAt4 + kUnits;
  static constexpr std::size_t kWeights = kOffset4 + 1;

  /// What each layer gave, place by place; for those who train.
  struct Trace {
    std::array<float, (BallPatch::kSide + 2) * (BallPatch::kSide + 2)> luma;  // with a border of 0
    std::array<float, BallPatch::kLuma * kFirst> first;                       // before the largest is taken
    std::array<float, BallPatch::kChroma * kDeep> deep;
    std::array<float, kSide2 * kSide2 * kSecond> second;  // before the largest is taken
    std::array<float, kFlat> flat;
    std::array<float, kUnits> units;
    float out;  // the logarithm of the odds
  };

  explicit BallNet(std::span<const float, kWeights> weights) : w_(weights) {}
  void run(const BallPatch& patch, Trace& trace) const;
  /// 0..1.
  double confidence(const BallPatch& patch) const;

 private:
  std::span<const float, kWeights> w_;
};

/// The patch as a mirror would show it.
void mirror(BallPatch& patch);

/// The weights that `sinew-sight train` found (docs/soccer-vision.md).
std::span<const float, BallNet::kWeights> trained_ball_weights();

}  // namespace sinew::soccer
