#pragma once
// Small matrices of fixed size.
// Shape:   R x C, row-major.
// Thread:  any.   RT: yes (on the stack; meant for up to 16 x 16).
#include <array>
#include <cstddef>
#include <optional>
#include <type_traits>
#include <utility>

#include "math/elementary.hpp"

namespace sinew::math {

template <int R, int C>
struct Mat {
  static_assert(R > 0 && C > 0);
  std::array<double, std::size_t(R) * std::size_t(C)> a{};

  constexpr Mat() = default;
  /// All elements, row by row.
  template <class... E>
  requires(sizeof...(E) == R * C && (std::is_convertible_v<E, double> && ...)) constexpr Mat(E... e)
      : a{static_cast<double>(e)...} {}

  static constexpr Mat identity() requires(R == C) {
    Mat m;
    for (int i = 0; i < R; ++i) m(i, i) = 1;
    return m;
  }
  static constexpr Mat diagonal(const Mat<R, 1>& d) requires(R == C) {
    Mat m;
    for (int i = 0; i < R; ++i) m(i, i) = d(i);
    return m;
  }

  constexpr double operator()(int r, int c) const { return a[std::size_t(r * C + c)]; }
  constexpr double& operator()(int r, int c) { return a[std::size_t(r * C + c)]; }
  constexpr double operator()(int i) const requires(C == 1) { return a[std::size_t(i)]; }
  constexpr double& operator()(int i) requires(C == 1) { return a[std::size_t(i)]; }

  constexpr Mat<C, R> transpose() const {
    Mat<C, R> t;
    for (int r = 0; r < R; ++r)
      for (int c = 0; c < C; ++c) t(c, r) = (*this)(r, c);
    return t;
  }
  template <int Rows, int Columns>
  constexpr Mat<Rows, Columns> block(int r0, int c0) const {
    Mat<Rows, Columns> b;
    for (int r = 0; r < Rows; ++r)
      for (int c = 0; c < Columns; ++c) b(r, c) = (*this)(r0 + r, c0 + c);
    return b;
  }
  template <int Rows, int Columns>
  constexpr void set_block(int r0, int c0, const Mat<Rows, Columns>& b) {
    for (int r = 0; r < Rows; ++r)
      for (int c = 0; c < Columns; ++c) (*this)(r0 + r, c0 + c) = b(r, c);
  }
  /// Makes a covariance exactly symmetric again after rounding: (A + A^T) / 2.
  constexpr Mat symmetric() const requires(R == C) {
    Mat m;
    for (int r = 0; r < R; ++r)
      for (int c = 0; c < C; ++c) m(r, c) = 0.5 * ((*this)(r, c) + (*this)(c, r));
    return m;
  }
  constexpr double trace() const requires(R == C) {
    double t = 0;
    for (int i = 0; i < R; ++i) t += (*this)(i, i);
    return t;
  }

  constexpr Mat& operator+=(const Mat& b) {
    for (std::size_t i = 0; i < a.size(); ++i) a[i] += b.a[i];
    return *this;
  }
  constexpr Mat& operator-=(const Mat& b) {
    for (std::size_t i = 0; i < a.size(); ++i) a[i] -= b.a[i];
    return *this;
  }
  constexpr Mat& operator*=(double s) {
    for (double& e : a) e *= s;
    return *this;
  }
  friend constexpr Mat operator+(Mat x, const Mat& y) { return x += y; }
  friend constexpr Mat operator-(Mat x, const Mat& y) { return x -= y; }
  friend constexpr Mat operator-(Mat x) { return x *= -1; }
  friend constexpr Mat operator*(Mat x, double s) { return x *= s; }
  friend constexpr Mat operator*(double s, Mat x) { return x *= s; }
  friend constexpr bool operator==(const Mat&, const Mat&) = default;
};

template <int N>
using Vec = Mat<N, 1>;

template <int R, int K, int C>
constexpr Mat<R, C> operator*(const Mat<R, K>& x, const Mat<K, C>& y) {
  Mat<R, C> m;
  for (int r = 0; r < R; ++r)
    for (int k = 0; k < K; ++k)
      for (int c = 0; c < C; ++c) m(r, c) += x(r, k) * y(k, c);
  return m;
}

template <int R, int C>
constexpr bool is_finite(const Mat<R, C>& m) {
  for (const double e : m.a)
    if (!is_finite(e)) return false;
  return true;
}

/// A = L L^T of a symmetric positive definite matrix; only its lower triangle is read.
template <int N>
struct Cholesky {
  Mat<N, N> l;  // lower triangle, zeros above

  /// A x = b for each column of b.
  template <int C>
  constexpr Mat<N, C> solve(Mat<N, C> b) const {
    for (int c = 0; c < C; ++c) {
      for (int i = 0; i < N; ++i) {
        for (int k = 0; k < i; ++k) b(i, c) -= l(i, k) * b(k, c);
        b(i, c) /= l(i, i);
      }
      for (int i = N - 1; i >= 0; --i) {
        for (int k = i + 1; k < N; ++k) b(i, c) -= l(k, i) * b(k, c);
        b(i, c) /= l(i, i);
      }
    }
    return b;
  }
  constexpr Mat<N, N> inverse() const { return solve(Mat<N, N>::identity()).symmetric(); }
};

/// Nothing when the matrix is not positive definite or not finite.
template <int N>
std::optional<Cholesky<N>> cholesky(const Mat<N, N>& a) {
  Cholesky<N> f;
  for (int i = 0; i < N; ++i)
    for (int j = 0; j <= i; ++j) {
      double s = a(i, j);
      for (int k = 0; k < j; ++k) s -= f.l(i, k) * f.l(j, k);
      if (i == j) {
        if (!(s > 0) || !is_finite(s)) return std::nullopt;
        f.l(i, i) = sqrt(s);
      } else {
        f.l(i, j) = s / f.l(j, j);
      }
    }
  return f;
}

/// Solves A x = b for a general square matrix by elimination with row pivots; nothing when A is singular or not finite.
template <int N, int C>
std::optional<Mat<N, C>> solve(Mat<N, N> a, Mat<N, C> b) {
  for (int p = 0; p < N; ++p) {
    int best = p;
    for (int r = p + 1; r < N; ++r)
      if (fabs(a(r, p)) > fabs(a(best, p))) best = r;
    if (!(fabs(a(best, p)) > 0) || !is_finite(a(best, p))) return std::nullopt;
    for (int c = 0; c < N && best != p; ++c) std::swap(a(p, c), a(best, c));
    for (int c = 0; c < C && best != p; ++c) std::swap(b(p, c), b(best, c));
    for (int r = p + 1; r < N; ++r) {
      const double f = a(r, p) / a(p, p);
      for (int c = p + 1; c < N; ++c) a(r, c) -= f * a(p, c);
      for (int c = 0; c < C; ++c) b(r, c) -= f * b(p, c);
    }
  }
  for (int r = N - 1; r >= 0; --r)
    for (int c = 0; c < C; ++c) {
      for (int k = r + 1; k < N; ++k) b(r, c) -= a(r, k) * b(k, c);
      b(r, c) /= a(r, r);
    }
  if (!is_finite(b)) return std::nullopt;
  return b;
}

template <int N>
std::optional<Mat<N, N>> inverse(const Mat<N, N>& a) {
  return solve(a, Mat<N, N>::identity());
}

}  // namespace sinew::math
