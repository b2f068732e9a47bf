#include "learn/dense_solver.hpp"

#include <algorithm>

#include "math/elementary.hpp"

namespace sinew::learn {
namespace {

/// The row from `first` on whose element in column `c` is the largest; of equal ones the first.
std::size_t pivot_row(std::span<const double> a, std::size_t n, std::size_t c) {
  std::size_t best = c;
  for (std::size_t r = c + 1; r < n; ++r)
    if (math::fabs(a[r * n + c]) > math::fabs(a[best * n + c])) best = r;
  return best;
}

}  // namespace

bool solve_in_place(std::span<double> a, std::span<double> b) {
  const std::size_t n = b.size();
  if (a.size() != n * n) return false;
  for (std::size_t p = 0; p < n; ++p) {
    const std::size_t best = pivot_row(a, n, p);
    double* const top = a.data() + p * n;
    if (best != p) {
      std::swap_ranges(top, top + n, a.data() + best * n);
      std::swap(b[p], b[best]);
    }
    if (!(math::fabs(top[p]) > 0) || !math::is_finite(top[p])) return false;
    for (std::size_t r = p + 1; r < n; ++r) {
      double* const row = a.data() + r * n;
      const double f = row[p] / top[p];
      if (f == 0) continue;
      for (std::size_t c = p + 1; c < n; ++c) row[c] -= f * top[c];
      b[r] -= f * b[p];
    }
  }
  for (std::size_t r = n; r-- > 0;) {
    for (std::size_t c = r + 1; c < n; ++c) b[r] -= a[r * n + c] * b[c];
    b[r] /= a[r * n + r];
    if (!math::is_finite(b[r])) return false;
  }
  return true;
}

}  // namespace sinew::learn
