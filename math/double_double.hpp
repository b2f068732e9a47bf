#pragma once
// Sums of two doubles (hi + lo, |lo| <= ulp(hi)/2): about 106 bits where one double is not enough. No FMA.
// Source:  T. J. Dekker, A floating-point technique for extending the available precision, Numer. Math. 18 (1971);
//          D. E. Knuth, The Art of Computer Programming 2, section 4.2.2, theorem B (two_sum).

namespace sinew::math::detail {

struct DoubleDouble {
  double hi, lo;
};

constexpr DoubleDouble two_sum(double a, double b) {
  const double s = a + b, bb = s - a;
  return {s, (a - (s - bb)) + (b - bb)};
}
/// Needs |a| >= |b| or a == 0.
constexpr DoubleDouble fast_two_sum(double a, double b) {
  const double s = a + b;
  return {s, b - (s - a)};
}
/// Exact for |a|, |b| below 2^996 as long as nothing underflows.
constexpr DoubleDouble two_product(double a, double b) {
  constexpr double kSplit = 134217729;  // 2^27 + 1
  const double ca = kSplit * a, ah = ca - (ca - a), al = a - ah;
  const double cb = kSplit * b, bh = cb - (cb - b), bl = b - bh;
  const double p = a * b;
  return {p, ((ah * bh - p) + ah * bl + al * bh) + al * bl};
}
constexpr DoubleDouble multiply(DoubleDouble a, DoubleDouble b) {
  const DoubleDouble p = two_product(a.hi, b.hi);
  return fast_two_sum(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
}
constexpr DoubleDouble add(DoubleDouble a, DoubleDouble b) {
  const DoubleDouble s = two_sum(a.hi, b.hi);
  return fast_two_sum(s.hi, s.lo + (a.lo + b.lo));
}

}  // namespace sinew::math::detail
