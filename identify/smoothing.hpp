#pragma once
#include <cstddef>
#include <span>

namespace sinew::identify {

/// Position, speed and acceleration of something measured now and then, at a time in between.
struct LocalMotion {
  double q = 0, v = 0, a = 0;
  double other = 0;  // of a second quantity that was measured with it: smoothed in the same way
};

/// Cubics through `q` and through `other` around time `t`, least squares with weights that fall like a
/// Gaussian of `window_s`. `other` may be empty. Times rise.
/// Errors:  false: fewer than 6 values within three windows to each side, or something is not finite.
/// Source:  A. Savitzky, M. Golay, Smoothing and differentiation of data (1964), for times of any distance.
/// Thread:  any.   RT: no.
bool local_motion(std::span<const double> time_s, std::span<const double> q, std::span<const double> other, double t,
                  double window_s, LocalMotion& motion);

}  // namespace sinew::identify
