// exp, log, pow, and the roots and remainders that belong to them.
// Source:  x = k ln 2 + r and x = 2^k m as in W. J. Cody and W. Waite, Software Manual for the Elementary Functions
//          (1980), ch. 5 and 6; exp by its Taylor series, log by 2 atanh((m - 1) / (m + 1)). pow carries the logarithm
//          in two doubles.
#include "math/double_double.hpp"
#include "math/elementary.hpp"

namespace sinew::math {
namespace {

using detail::DoubleDouble;

constexpr double kInvLn2 = 0x1.71547652b82fep+0;
// ln 2 in 42 + 53 bits: products of the first part with |k| < 2^11 are exact.
constexpr double kLn2Hi = 0x1.62e42fefa3800p-1, kLn2Lo = 0x1.ef35793c76730p-45;

constexpr double power_of_two(int k) { return std::bit_cast<double>(std::uint64_t(k + 1023) << 52); }

/// y * 2^k for y near 1, rounded once.
double scale(double y, int k) {
  if (k > 1023) return y * 0x1p1000 * power_of_two(k - 1000);
  if (k < -1021) return y * power_of_two(k + 200) * 0x1p-200;
  return y * power_of_two(k);
}

/// exp(h + l) for -746 <= h <= 711, |l| far below |h|.
double exp_sum(double h, double l) {
  const double turns = h * kInvLn2;
  const int k = static_cast<int>(turns + (turns < 0 ? -0.5 : 0.5));
  const double hi = h - k * kLn2Hi, lo = k * kLn2Lo - l, r = hi - lo;
  double p = 1.0 / 6227020800.0;  // 1/13!; what follows is below 2^-57
  p = p * r + 1.0 / 479001600.0;
  p = p * r + 1.0 / 39916800.0;
  p = p * r + 1.0 / 3628800.0;
  p = p * r + 1.0 / 362880.0;
  p = p * r + 1.0 / 40320.0;
  p = p * r + 1.0 / 5040.0;
  p = p * r + 1.0 / 720.0;
  p = p * r + 1.0 / 120.0;
  p = p * r + 1.0 / 24.0;
  p = p * r + 1.0 / 6.0;
  p = p * r + 0.5;
  const DoubleDouble one = detail::fast_two_sum(1, hi);
  return scale(one.hi + (one.lo + (r * r * p - lo)), k);
}

struct Mantissa {
  double m;  // sqrt(1/2) .. sqrt(2)
  int k;
};
/// For finite x > 0.
Mantissa split(double x) {
  int k = -1023;
  if (x < 0x1p-1022) x *= 0x1p54, k -= 54;
  std::uint64_t bits = std::bit_cast<std::uint64_t>(x);
  k += static_cast<int>(bits >> 52);
  bits = (bits & 0xfffffffffffff) | 0x3ff0000000000000;
  double m = std::bit_cast<double>(bits);
  if (m > 0x1.6a09e667f3bcdp+0) m *= 0.5, ++k;  // sqrt 2
  return {m, k};
}

/// 2/5 + 2/7 z + ... + 2/23 z^9: the series of 2 atanh(s) from s^5 on, z = s^2 <= 0.0295.
double log_tail(double z) {
  double p = 2.0 / 23;
  p = p * z + 2.0 / 21;
  p = p * z + 2.0 / 19;
  p = p * z + 2.0 / 17;
  p = p * z + 2.0 / 15;
  p = p * z + 2.0 / 13;
  p = p * z + 2.0 / 11;
  p = p * z + 2.0 / 9;
  p = p * z + 2.0 / 7;
  return p * z + 2.0 / 5;
}

/// log(x) to about 64 bits, for finite x > 0.
DoubleDouble log_sum(double x) {
  const auto [m, k] = split(x);
  const double f = m - 1;  // exact
  const DoubleDouble d = detail::two_sum(m, 1);
  const double q = f / d.hi;
  const DoubleDouble back = detail::two_product(q, d.hi);
  const DoubleDouble s{q, (((f - back.hi) - back.lo) - q * d.lo) / d.hi};
  const DoubleDouble z = detail::multiply(s, s);
  const DoubleDouble c = detail::fast_two_sum(2.0 / 3, 0x1.5555555555555p-55 + z.hi * log_tail(z.hi));
  const DoubleDouble series = detail::add({2 * s.hi, 2 * s.lo}, detail::multiply(detail::multiply(z, s), c));
  const DoubleDouble power = detail::fast_two_sum(k * kLn2Hi, k * kLn2Lo);
  return detail::add(power, series);
}

enum class Parity { fraction, even, odd };
Parity parity(double y) {
  if (fabs(y) >= 0x1p53) return Parity::even;
  if (trunc(y) != y) return Parity::fraction;
  return (static_cast<std::int64_t>(y) & 1) != 0 ? Parity::odd : Parity::even;
}

/// x is 0 or infinite, y is not 0 nor NaN.
double pow_of_limit(double x, double y) {
  const double magnitude = (x == 0) == (y < 0) ? kInf : 0;
  return sign_bit(x) && parity(y) == Parity::odd ? -magnitude : magnitude;
}

}  // namespace

double exp(double x) {
  if (is_nan(x)) return kNan;
  if (x > 711) return kInf;
  if (x < -746) return 0;
  return exp_sum(x, 0);
}

double log(double x) {
  if (is_nan(x) || x < 0) return kNan;
  if (x == 0) return -kInf;
  if (!is_finite(x)) return x;
  const auto [m, k] = split(x);
  const double f = m - 1, s = f / (2 + f), z = s * s, half = 0.5 * f * f;
  const double r = z * (2.0 / 3 + z * log_tail(z));
  // log(1 + f) = f - f^2/2 + s (f^2/2 + r)
  if (k == 0) return f - (half - s * (half + r));
  return k * kLn2Hi - ((half - (s * (half + r) + k * kLn2Lo)) - f);
}

double pow(double x, double y) {
  if (y == 0 || x == 1) return 1;
  if (is_nan(x) || is_nan(y)) return kNan;
  const double a = fabs(x);
  if (!is_finite(y)) {
    if (a == 1) return 1;
    return (a > 1) == (y > 0) ? kInf : 0;
  }
  if (x == 0 || !is_finite(x)) return pow_of_limit(x, y);
  double sign = 1;
  if (x < 0) {
    const Parity p = parity(y);
    if (p == Parity::fraction) return kNan;
    if (p == Parity::odd) sign = -1;
  }
  if (a == 1) return sign;
  if (fabs(y) > 0x1p65) return (a > 1) == (y > 0) ? sign * kInf : sign * 0.0;  // |log a| >= 2^-53
  if (fabs(y) < 0x1p-65) return sign;                                          // |log a| < 2^10
  const DoubleDouble l = detail::multiply(log_sum(a), {y, 0});
  if (l.hi > 711) return sign * kInf;
  if (l.hi < -746) return sign * 0.0;
  return sign * exp_sum(l.hi, l.lo);
}

double hypot(double x, double y) {
  if (!is_finite(x) || !is_finite(y)) {
    const bool infinite = (!is_nan(x) && !is_finite(x)) || (!is_nan(y) && !is_finite(y));
    return infinite ? kInf : kNan;
  }
  x = fabs(x), y = fabs(y);
  if (x > 0x1p500 || y > 0x1p500) return sqrt(x * 0x1p-600 * (x * 0x1p-600) + y * 0x1p-600 * (y * 0x1p-600)) * 0x1p600;
  if (x < 0x1p-400 && y < 0x1p-400) {
    x *= 0x1p600, y *= 0x1p600;
    return sqrt(x * x + y * y) * 0x1p-600;
  }
  return sqrt(x * x + y * y);
}

double fmod(double x, double y) {
  if (is_nan(x) || is_nan(y) || !is_finite(x) || y == 0) return kNan;
  if (!is_finite(y) || fabs(x) < fabs(y)) return x;
  // Long division in integers: 11 bits at a time fit above the 53 bits of the remainder.
  struct Parts {
    std::uint64_t m;
    int e;
  };
  const auto parts = [](double v) -> Parts {
    const std::uint64_t bits = std::bit_cast<std::uint64_t>(fabs(v));
    const int e = static_cast<int>(bits >> 52);
    return e == 0 ? Parts{bits, 1} : Parts{(bits & 0xfffffffffffff) | 0x10000000000000, e};
  };
  const Parts a = parts(x), b = parts(y);
  std::uint64_t r = a.m % b.m;
  for (int left = a.e - b.e; left > 0 && r != 0;) {
    const int shift = left < 11 ? left : 11;
    r = (r << shift) % b.m;
    left -= shift;
  }
  // r * 2^(b.e - 1075) in two exact steps: r < 2^53, and r * 2^-1074 has only bits that a subnormal has.
  const double result = static_cast<double>(r) * 0x1p-1074 * power_of_two(b.e <= 1023 ? b.e - 1 : 1022);
  return copysign(b.e <= 1023 ? result : result * power_of_two(b.e - 1023), x);
}

}  // namespace sinew::math
