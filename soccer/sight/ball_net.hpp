#pragma once
// A small network that says whether a patch shows a ball.
#include <span>

#include "soccer/sight/ball_patch.hpp"

namespace sinew::soccer {

/// Two hidden layers of rectified units and a logistic output. Sums run in the order of the inputs, each unit on its
/// own: the same bytes on every machine.
/// Thread:  any.   RT: yes.
class BallNet {
 public:
  static constexpr std::size_t kInputs = BallPatch::kValues, kFirst = 24, kSecond = 12;
  static constexpr std::size_t kWeights = (kInputs + 1) * kFirst + (kFirst + 1) * kSecond + kSecond + 1;

  /// Shape:   for each input its weights to the first layer, then this layer's offsets; likewise the second; then the
  ///          output's weights and its offset.
  explicit BallNet(std::span<const float, kWeights> weights) : w_(weights) {}
  /// 0..1.
  double confidence(const BallPatch& patch) const;

 private:
  std::span<const float, kWeights> w_;
};

/// The weights that `sinew-sight train` found (docs/soccer-vision.md).
std::span<const float, BallNet::kWeights> trained_ball_weights();

}  // namespace sinew::soccer
