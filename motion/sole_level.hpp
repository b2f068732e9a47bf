#pragma once
#include <array>
#include <span>

#include "motion/figure.hpp"

namespace sinew::motion {

/// Turns the ankles of a body that stands on both feet until each sole is pressed evenly: whatever the zeros of its
/// joints are, both then lie flat. Slow, for poses that are held. What both soles feel forward is where the weight
/// is, and the body leans against it; what they feel differently is a strain between the legs, and gives way.
/// Thread:  owner.   RT: yes.
class SoleLevel {
 public:
  static constexpr double kGain_radps = 0.1;  // for a sole that is pressed at its edge only
  static constexpr double kMost_rad = 0.3;
  static constexpr double kLeast_n = 2;  // of a sole that stands

  explicit SoleLevel(const Figure& figure);
  /// Nothing happens while a sole is in the air.
  void step(const std::array<SoleForces, 2>& soles_n, double dt_s);
  /// Adds the turns to the ankles' angles.
  void add_to(std::span<double> joints_rad) const;

  /// By foot: pitch, roll; a state.
  std::array<double, 4> turn_rad{};

 private:
  std::array<std::size_t, 4> joint_{};
  std::array<double, 4> sign_{};
};

/// All eight cells are pressed.
bool lie_flat(const std::array<SoleForces, 2>& soles_n);

}  // namespace sinew::motion
