#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "learn/q_function.hpp"
#include "robots/quad/landing_view.hpp"

namespace sinew::control {

/// What a landing policy wants: a speed along world x and y, and a speed downwards.
struct LandingWish {
  std::array<double, 2> aside_mps{};
  double sink_mps = 0;
};

/// Which actions a policy chooses from.
enum class LandingActions : std::uint8_t { discrete, continuous };

/// Two learners: one for the way aside, used for both axes, and one for the way down.
/// - Aside: distance and its rate along one axis. Mirrored, so that the pad always lies ahead: what is learned on one
///   side holds on the other. Action: speed towards the pad.
/// - Down: height, rate of sinking, and distance aside of both axes together. Action: speed of sinking.
/// Distances enter as d / (d + kNear_m): near the pad differences of centimetres matter, far from it they do not.
/// One grid over all six numbers would have 3^6 and more features times actions, gigabytes of sums.
/// Thread:  owner to make, then any.   RT: wish() yes.
class LandingPolicy {
 public:
  static constexpr double kNear_m = 0.25, kSlow_mps = 0.3;
  using State = std::array<double, learn::RadialBasis::kMostAxes>;

  explicit LandingPolicy(LandingActions actions);

  /// States of the learners. Aside: `mirrored` is true when the pad lies on the negative side.
  static State state_aside(const LandingView& view, std::size_t axis, bool& mirrored);
  static State state_down(const LandingView& view);

  /// The best actions.
  LandingWish wish(const LandingView& view) const noexcept;

  learn::QFunction aside, down;
};

/// Weights as text: numbers between blanks or line ends, and back. Each is rounded to a float on the way out, so a
/// policy and its text are the same once it has been read again.
std::string weights_text(std::span<const double> weights);
/// Why the text does not give these weights, in words; empty when it does, and `weights` then has them.
std::string read_weights(std::string_view text, std::span<double> weights);

}  // namespace sinew::control
