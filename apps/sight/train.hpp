#pragma once
// The ball classifier learned from scenes with truth, and from photos.
#include <span>
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

/// Patches of candidates of scenes first .. first + count - 1: all of balls, as many more cut a little off them, and
/// one of `kOneOf` of others.
/// `as_they_come`: exactly the candidates.
void collect(SceneMaker& maker, std::uint64_t first, std::uint64_t count, bool as_they_come, std::vector<Example>& out);

/// Patches kept in a file of this machine. False: `why`; a file of another shape of patch is refused.
bool save(const std::string& path, std::span<const Example> examples, std::string& why);
bool load(const std::string& path, std::vector<Example>& out, std::string& why);

struct Training {
  int epochs = 16;
  std::uint64_t seed = 1;
  double rate = 2e-3;
};
/// By Adam on the cross entropy; patches are mirrored, shaded, tinted and made noisy at random. The same examples give
/// the same weights on this machine. Source:  D. Kingma and J. Ba, Adam: a method for stochastic optimization, ICLR
/// 2015, algorithm 1.
std::vector<float> train(std::span<const Example> examples, const Training& how);

/// Turns confidences into shares: scales the logarithm of the odds and adds to it, so that the cross entropy of these
/// examples, taken as they come, is least. Source:  J. Platt, Probabilistic outputs for support vector machines, 1999.
void calibrate(std::vector<float>& weights, std::span<const Example> as_they_come);

/// A source file of soccer/sight with these weights.
std::string weights_source(const std::vector<float>& weights, const std::string& command);

}  // namespace sinew::sight
