#pragma once
// The ball classifier learned from scenes with truth, and from photos.
#include <string>
#include <vector>

#include "apps/sight/scenes.hpp"

namespace sinew::sight {

struct Example {
  soccer::BallPatch patch;
  bool is_ball = false;
};

/// What a candidate is, by the truth.
enum class Verdict : std::uint8_t { ball, not_ball, unclear };
Verdict verdict(const soccer::BallCandidate& candidate, const std::optional<Scene::Ball>& ball);

/// Patches of all candidates of scenes first .. first + count - 1.
void collect(SceneMaker& maker, std::uint64_t first, std::uint64_t count, std::vector<Example>& out);

struct Training {
  int epochs = 16;
  std::uint64_t seed = 1;
  double rate = 2e-3;
};
/// By Adam on the cross entropy; patches are mirrored at random. The same examples give the same weights on this
/// machine. Source:  D. Kingma and J. Ba, Adam: a method for stochastic optimization, ICLR 2015, algorithm 1.
std::vector<float> train(const std::vector<Example>& examples, const Training& how);

/// A source file of soccer/sight with these weights.
std::string weights_source(const std::vector<float>& weights, const std::string& command);

}  // namespace sinew::sight
