#pragma once
// The moving things on and in front of the desk: the platform under the head, and the ball.
#include <array>

#include "math/linear.hpp"
#include "math/random.hpp"
#include "robots/desk_head/world/head_dynamics.hpp"

namespace sinew::plant {

/// A smooth function of time: a sum of sines, with its derivatives.
class Wave {
 public:
  static constexpr std::size_t kSines = 3;
  struct Value {
    double x = 0, dx = 0, ddx = 0;
  };
  Wave() = default;
  /// Never beyond +-amplitude. Frequencies are drawn up to a quarter around `hz`, phases anywhere.
  Wave(double amplitude, const std::array<double, kSines>& hz, math::Random& random);
  Value at(double t_s) const;

 private:
  std::array<double, kSines> amplitude_{}, rate_radps_{}, phase_{};
};

/// A platform that rolls and pitches by up to `tilt_rad` and yaws by up to `yaw_rad` about a fixed pivot.
class Rocking {
 public:
  Rocking(double tilt_rad, double yaw_rad, std::uint64_t seed);
  struct State {
    math::Quat q_world_base;
    LinkMotion motion;  // gravity included, as an accelerometer feels it
  };
  State at(double t_s) const;

 private:
  Wave roll_, pitch_, yaw_;
};

/// The ball's way in front of the head: smooth, sometimes fast.
class BallPath {
 public:
  explicit BallPath(double speed, std::uint64_t seed);
  math::Vec3 at(double t_s) const;

 private:
  double speed_;
  Wave x_, y_, z_, pace_;
};

}  // namespace sinew::plant
