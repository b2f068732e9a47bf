#include "identify/dense.hpp"

#include <algorithm>
#include <numeric>

#include "math/elementary.hpp"

namespace sinew::identify {
namespace {

/// The lower triangle L of a = L L^T, in place; what is above stays.
bool factor(Dense& a) {
  for (std::size_t i = 0; i < a.rows(); ++i)
    for (std::size_t j = 0; j <= i; ++j) {
      double s = a(i, j);
      for (std::size_t k = 0; k < j; ++k) s -= a(i, k) * a(j, k);
      if (i == j) {
        if (!(s > 0) || !math::is_finite(s)) return false;
        a(i, i) = math::sqrt(s);
      } else {
        a(i, j) = s / a(j, j);
      }
    }
  return true;
}

void substitute(const Dense& l, std::vector<double>& b) {
  const std::size_t n = l.rows();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < i; ++k) b[i] -= l(i, k) * b[k];
    b[i] /= l(i, i);
  }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t k = i + 1; k < n; ++k) b[i] -= l(k, i) * b[k];
    b[i] /= l(i, i);
  }
}

/// Rotates rows and columns p and q so that a(p, q) becomes 0.
void rotate(Dense& a, Dense& v, std::size_t p, std::size_t q) {
  const double theta = (a(q, q) - a(p, p)) / (2 * a(p, q));
  const double t = (theta < 0 ? -1 : 1) / (math::fabs(theta) + math::sqrt(theta * theta + 1));
  const double c = 1 / math::sqrt(t * t + 1), s = t * c;
  for (std::size_t k = 0; k < a.rows(); ++k) {
    const double kp = a(k, p), kq = a(k, q);
    a(k, p) = c * kp - s * kq, a(k, q) = s * kp + c * kq;
  }
  for (std::size_t k = 0; k < a.rows(); ++k) {
    const double pk = a(p, k), qk = a(q, k);
    a(p, k) = c * pk - s * qk, a(q, k) = s * pk + c * qk;
    const double vp = v(k, p), vq = v(k, q);
    v(k, p) = c * vp - s * vq, v(k, q) = s * vp + c * vq;
  }
}

}  // namespace

std::optional<Dense> inverse_of_positive(const Dense& a) {
  Dense l = a;
  if (!factor(l)) return std::nullopt;
  Dense inverse(a.rows(), a.rows());
  for (std::size_t c = 0; c < a.rows(); ++c) {
    std::vector<double> unit(a.rows());
    unit[c] = 1;
    substitute(l, unit);
    for (std::size_t r = 0; r < a.rows(); ++r) inverse(r, c) = unit[r];
  }
  return inverse;
}

std::optional<std::vector<double>> solve_positive(const Dense& a, const std::vector<double>& b) {
  Dense l = a;
  if (!factor(l)) return std::nullopt;
  std::vector<double> x = b;
  substitute(l, x);
  return x;
}

SymmetricEigen symmetric_eigen(Dense a) {
  constexpr int kSweeps = 60;
  const std::size_t n = a.rows();
  Dense v(n, n);
  for (std::size_t i = 0; i < n; ++i) v(i, i) = 1;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    bool turned = false;
    for (std::size_t p = 0; p < n; ++p)
      for (std::size_t q = p + 1; q < n; ++q) {
        const double size = math::sqrt(math::fabs(a(p, p) * a(q, q)));
        if (!(math::fabs(a(p, q)) > 1e-16 * size) || math::fabs(a(p, q)) < 1e-300) continue;
        rotate(a, v, p, q);
        turned = true;
      }
    if (!turned) break;
  }
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return a(i, i) < a(j, j); });
  SymmetricEigen result{std::vector<double>(n), Dense(n, n)};
  for (std::size_t i = 0; i < n; ++i) {
    result.values[i] = a(order[i], order[i]);
    for (std::size_t k = 0; k < n; ++k) result.vectors(k, i) = v(k, order[i]);
  }
  return result;
}

}  // namespace sinew::identify
