#include "identify/smoothing.hpp"

#include <algorithm>

#include "math/matrix.hpp"

namespace sinew::identify {

bool local_motion(std::span<const double> time_s, std::span<const double> q, std::span<const double> other, double t,
                  double window_s, LocalMotion& motion) {
  constexpr double kReach = 3;  // windows; the weight there is 0.011
  constexpr std::ptrdiff_t kLeast = 6;
  const auto first = std::lower_bound(time_s.begin(), time_s.end(), t - kReach * window_s) - time_s.begin();
  const auto end = std::upper_bound(time_s.begin(), time_s.end(), t + kReach * window_s) - time_s.begin();
  if (end - first < kLeast) return false;
  math::Mat<4, 4> normal;
  math::Mat<4, 2> right;
  for (auto i = static_cast<std::size_t>(first); i < static_cast<std::size_t>(end); ++i) {
    const double x = (time_s[i] - t) / window_s, w = math::exp(-0.5 * x * x);
    const double power[4] = {1, x, x * x, x * x * x};
    for (int r = 0; r < 4; ++r) {
      for (int c = 0; c < 4; ++c) normal(r, c) += w * power[r] * power[c];
      right(r, 0) += w * power[r] * q[i];
      if (!other.empty()) right(r, 1) += w * power[r] * other[i];
    }
  }
  const auto cubic = math::solve(normal, right);
  if (!cubic) return false;
  motion = {(*cubic)(0, 0), (*cubic)(1, 0) / window_s, 2 * (*cubic)(2, 0) / (window_s * window_s), (*cubic)(0, 1)};
  return math::is_finite(motion.other);
}

}  // namespace sinew::identify
