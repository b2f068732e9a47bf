#pragma once
// Elementary functions with the same bits on every compiler, C library and CPU; rt, control and vision use only these.
// Everything here is IEEE-754 addition, multiplication, division and square root in a fixed order, without contraction
// to FMA, plus integer operations. Every NaN that comes out is kNan, whatever went in.
// Units:   angles in rad.
// Thread:  any.   RT: yes.
// Accuracy: the ULP in the comments are the largest errors seen by tests/math/accuracy_test.cpp, which asserts them.
#include <bit>
#include <cstdint>

namespace sinew::math {

inline constexpr double kPi = 0x1.921fb54442d18p+1;
inline constexpr double kInf = __builtin_inf();
inline constexpr double kNan = std::bit_cast<double>(std::uint64_t{0x7ff8000000000000});
inline constexpr float kNanF = std::bit_cast<float>(std::uint32_t{0x7fc00000});

constexpr bool is_nan(double x) { return x != x; }
constexpr bool is_finite(double x) {
  return (std::bit_cast<std::uint64_t>(x) & 0x7ff0000000000000) != 0x7ff0000000000000;
}
constexpr bool sign_bit(double x) { return (std::bit_cast<std::uint64_t>(x) >> 63) != 0; }
constexpr double fabs(double x) { return std::bit_cast<double>(std::bit_cast<std::uint64_t>(x) & ~(1ull << 63)); }
constexpr float fabs(float x) { return std::bit_cast<float>(std::bit_cast<std::uint32_t>(x) & ~(1u << 31)); }
constexpr double copysign(double magnitude, double sign) { return sign_bit(sign) ? -fabs(magnitude) : fabs(magnitude); }
/// The one NaN for every NaN; other values unchanged.
constexpr double canonical(double x) { return is_nan(x) ? kNan : x; }
constexpr float canonical(float x) { return x != x ? kNanF : x; }

/// Correctly rounded (0.5 ULP); kNan below zero, -0 for -0.
inline double sqrt(double x) { return x < 0 ? kNan : canonical(__builtin_sqrt(x)); }
inline float sqrt(float x) { return x < 0 ? kNanF : canonical(__builtin_sqrtf(x)); }

/// To an integer: towards zero, down, up, and to nearest with halves away from zero. Exact; infinities and the sign of
/// zero are kept.
constexpr double trunc(double x) {
  if (is_nan(x)) return kNan;
  if (fabs(x) >= 0x1p52) return x;  // already an integer, or infinite
  return copysign(static_cast<double>(static_cast<std::int64_t>(x)), x);
}
constexpr double floor(double x) {
  const double t = trunc(x);
  return t > x ? t - 1 : t;
}
constexpr double ceil(double x) {
  const double t = trunc(x);
  return t < x ? copysign(t + 1, x) : t;
}
constexpr double round(double x) {
  const double t = trunc(x);
  return fabs(x - t) >= 0.5 ? t + copysign(1, x) : t;
}
/// Exact remainder with the sign of x, |result| < |y|. kNan for infinite x or zero y.
double fmod(double x, double y);

struct SinCos {
  double sin, cos;
};
/// At most 1 ULP for every finite argument, however large; kNan for infinite ones.
double sin(double x);
double cos(double x);
SinCos sincos(double x);
/// At most 1 ULP for every finite argument; kNan for infinite ones.
double tan(double x);

/// At most 1 ULP; atan(+-inf) = +-pi/2.
double atan(double x);
/// Angle of (x, y), -pi..pi, at most 2 ULP; zeros and infinities as in C (atan2(0, -0) = pi).
double atan2(double y, double x);
/// Through double, then rounded once: 0.5000001 ULP.
float atan2(float y, float x);
/// At most 2 ULP; kNan outside -1..1.
double asin(double x);
double acos(double x);

/// At most 1 ULP, also where the result is subnormal; overflows to infinity above 709.78, to 0 below -745.13.
double exp(double x);
/// At most 1 ULP; log(0) = -inf, kNan below zero.
double log(double x);
/// At most 1 ULP; special cases as in C (pow(x, 0) = 1 and pow(1, y) = 1 also for NaN; kNan for a negative base with a
/// fractional exponent).
double pow(double x, double y);
/// sqrt(x^2 + y^2) without overflow or underflow on the way, at most 2 ULP.
double hypot(double x, double y);

/// x shifted by whole turns to -pi..pi. Exact to about |x| * 1e-16; meant for angles of some turns.
inline double wrap_pi(double x) {
  if (fabs(x) <= kPi) return x;
  return is_finite(x) ? x - 2 * kPi * round(x / (2 * kPi)) : kNan;
}

}  // namespace sinew::math
