// sin, cos, tan and their inverses.
// Source:  reduction modulo pi/2 after W. J. Cody and W. Waite, Software Manual for the Elementary Functions (1980),
//          ch. 8, in three parts of pi/2, and for large arguments after M. Payne and R. Hanek, Radian reduction for
//          trigonometric functions, SIGNUM 18 (1983), in integers. Kernels are Taylor series, long enough that what is
//          cut off lies below 2^-58; atan by a table of atan(k/16).
#include <array>

#include "math/double_double.hpp"
#include "math/elementary.hpp"

namespace sinew::math {
namespace {

using detail::DoubleDouble;
using detail::two_product;
using detail::two_sum;

constexpr DoubleDouble kHalfPi{0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54};
constexpr DoubleDouble kPiParts{0x1.921fb54442d18p+1, 0x1.1a62633145c07p-53};

/// x = quadrant * pi/2 + angle, |angle| <= pi/4 (a little more at the seams); quadrant modulo 4.
struct Reduced {
  unsigned quadrant;
  DoubleDouble angle;
};

// 2/pi in binary, after 64 zero bits: the bits that an argument of any size needs.
constexpr std::array<std::uint32_t, 42> kTwoOverPi{
    0x00000000, 0x00000000, 0xA2F9836E, 0x4E441529, 0xFC2757D1, 0xF534DDC0, 0xDB629599, 0x3C439041,
    0xFE5163AB, 0xDEBBC561, 0xB7246E3A, 0x424DD2E0, 0x06492EEA, 0x09D1921C, 0xFE1DEB1C, 0xB129A73E,
    0xE88235F5, 0x2EBB4484, 0xE99C7026, 0xB45F7E41, 0x3991D639, 0x835339F4, 0x9C845F8B, 0xBDF9283B,
    0x1FF897FF, 0xDE05980F, 0xEF2F118B, 0x5A0A6D1F, 0x6D367ECF, 0x27CB09B7, 0x4F463F66, 0x9E5FEA2D,
    0x7527BAC7, 0xEBE5F17B, 0x3D0739F7, 0x8A5292EA, 0x6BFB5FB1, 0x1F8D5D08, 0x56033046, 0xFC7B6BAB};

/// 32 bits of a big-endian row of words, from bit `at` on.
std::uint32_t bits_at(const std::uint32_t* words, unsigned at) {
  const unsigned i = at / 32, shift = at % 32;
  return shift == 0 ? words[i] : (words[i] << shift) | (words[i + 1] >> (32 - shift));
}

/// For finite x >= 2^-9. x = m * 2^e; the bits of 2/pi whose product with x is a multiple of 4 are skipped, 192 bits
/// are multiplied by m modulo 2^192, and the top two bits of that are the quadrant.
Reduced reduce_by_integers(double x) {
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(x);
  const int e = static_cast<int>(bits >> 52 & 0x7ff) - 1075;
  const std::uint64_t m = (bits & 0xfffffffffffff) | 0x10000000000000;
  const std::uint64_t m_low = m & 0xffffffff, m_high = m >> 32;

  std::array<std::uint32_t, 8> product{};  // big-endian, six words and zeros behind them
  std::uint64_t carry = 0;
  std::uint64_t previous = 0;  // the word below, to be multiplied by the high half of m
  for (int i = 5; i >= 0; --i) {
    const std::uint64_t word = bits_at(kTwoOverPi.data(), static_cast<unsigned>(62 + e + 32 * i));
    const std::uint64_t low = word * m_low, high = previous * m_high;
    const std::uint64_t sum = (low & 0xffffffff) + (high & 0xffffffff) + (carry & 0xffffffff);
    product[static_cast<unsigned>(i)] = static_cast<std::uint32_t>(sum);
    carry = (sum >> 32) + (low >> 32) + (high >> 32) + (carry >> 32);
    previous = word;
  }
  unsigned quadrant = product[0] >> 30;
  const bool upper_half = (product[0] >> 29 & 1) != 0;
  std::array<std::uint32_t, 9> fraction{};  // after the quadrant; leading one searched below
  for (unsigned i = 0; i < 6; ++i) fraction[i] = bits_at(product.data(), 2 + 32 * i);
  if (upper_half) {  // round to the next quadrant: fraction - 1, held as its absolute value
    ++quadrant;
    std::uint64_t borrow = 1;
    for (unsigned i = 6; i-- > 0;) {
      const std::uint64_t inverted = std::uint64_t{static_cast<std::uint32_t>(~fraction[i])} + borrow;
      fraction[i] = static_cast<std::uint32_t>(inverted);
      borrow = inverted >> 32;
    }
  }
  unsigned zeros = 0;
  while (zeros < 160 && (fraction[zeros / 32] >> (31 - zeros % 32) & 1) == 0) ++zeros;
  const auto take53 = [&](unsigned at) {
    const std::uint64_t top = std::uint64_t{bits_at(fraction.data(), at)} << 32 | bits_at(fraction.data(), at + 32);
    return static_cast<double>(top >> 11);
  };
  const double scale = std::bit_cast<double>(std::uint64_t{1023 - 53 - zeros} << 52);
  const double hi = take53(zeros) * scale, lo = zeros < 80 ? take53(zeros + 53) * scale * 0x1p-53 : 0;
  DoubleDouble angle = detail::multiply({hi, lo}, kHalfPi);
  if (upper_half) angle = {-angle.hi, -angle.lo};
  return {quadrant & 3, angle};
}

/// For finite x >= 0.
Reduced reduce(double x) {
  if (x <= kPi / 4) return {0, {x, 0}};
  if (x < 0x1p20) {
    // pi/2 in parts of 33, 33 and 53 bits: the first two products with n < 2^20 are exact.
    constexpr double kPart1 = 0x1.921fb544p+0, kPart2 = 0x1.0b4611a6p-34, kPart3 = 0x1.3198a2e037073p-69;
    const double n = static_cast<double>(static_cast<std::int32_t>(x * 0x1.45f306dc9c883p-1 + 0.5));
    const DoubleDouble rest = two_sum(x - n * kPart1, -(n * kPart2));
    const DoubleDouble angle = two_sum(rest.hi, rest.lo - n * kPart3);
    // Closer to a multiple of pi/2 than this, the three parts leave too few bits.
    if (fabs(angle.hi) > 0x1p-20) return {static_cast<unsigned>(n) & 3, angle};
  }
  return reduce_by_integers(x);
}

/// Both kernels: the function of a.hi + a.lo, |a| <= pi/4; hi is the rounded value.
DoubleDouble sin_kernel(DoubleDouble a) {
  const double x = a.hi, z = x * x, v = z * x;
  constexpr double s3 = 1.0 / 120, s4 = -1.0 / 5040, s5 = 1.0 / 362880, s6 = -1.0 / 39916800, s7 = 1.0 / 6227020800.0,
                   s8 = -1.0 / 1307674368000.0, s9 = 1.0 / 355687428096000.0;
  const double r = s3 + z * (s4 + z * (s5 + z * (s6 + z * (s7 + z * (s8 + z * s9)))));
  // sin(x + lo) = sin x + lo * (1 - x^2/2)
  return detail::fast_two_sum(x, -((z * (0.5 * a.lo - v * r) - a.lo) - v * (-1.0 / 6)));
}

DoubleDouble cos_kernel(DoubleDouble a) {
  const double x = a.hi, z = x * x, half = 0.5 * z, w = 1 - half;
  constexpr double c2 = 1.0 / 24, c3 = -1.0 / 720, c4 = 1.0 / 40320, c5 = -1.0 / 3628800, c6 = 1.0 / 479001600.0,
                   c7 = -1.0 / 87178291200.0, c8 = 1.0 / 20922789888000.0;
  const double r = z * (c2 + z * (c3 + z * (c4 + z * (c5 + z * (c6 + z * (c7 + z * c8))))));
  return detail::fast_two_sum(w, ((1 - w) - half) + (z * r - x * a.lo));
}

// atan(k/16) as hi + lo.
constexpr std::array<DoubleDouble, 17> kAtan{{{0x0.0p+0, 0x0.0p+0},
                                              {0x1.ff55bb72cfdeap-5, -0x1.c934d86d23f1dp-60},
                                              {0x1.fd5ba9aac2f6ep-4, -0x1.cd37686760c17p-59},
                                              {0x1.7b97b4bce5b02p-3, 0x1.347b0b4f881cap-58},
                                              {0x1.f5b75f92c80ddp-3, 0x1.8ab6e3cf7afbdp-57},
                                              {0x1.362773707ebccp-2, -0x1.963a544b672d8p-57},
                                              {0x1.6f61941e4def1p-2, -0x1.c63aae6f6e918p-56},
                                              {0x1.a64eec3cc23fdp-2, -0x1.24dec1b50b7ffp-56},
                                              {0x1.dac670561bb4fp-2, 0x1.a2b7f222f65e2p-56},
                                              {0x1.0657e94db30d0p-1, -0x1.d5b495f6349e6p-56},
                                              {0x1.1e00babdefeb4p-1, -0x1.928df287a668fp-58},
                                              {0x1.345f01cce37bbp-1, 0x1.1021137c71102p-55},
                                              {0x1.4978fa3269ee1p-1, 0x1.2419a87f2a458p-56},
                                              {0x1.5d58987169b18p-1, 0x1.0028e4bc5e7cap-57},
                                              {0x1.700a7c5784634p-1, -0x1.8c34d25aadef6p-56},
                                              {0x1.819d0b7158a4dp-1, -0x1.bf76229d3b917p-56},
                                              {0x1.921fb54442d18p-1, 0x1.1a62633145c07p-55}}};

/// atan(num/den) as hi + lo, for 0 <= num <= den. Exact but for some 2^-54 when one of them is 1; otherwise the
/// rounding of c * den adds up to one more.
DoubleDouble atan_ratio(double num, double den) {
  const double q = num / den;
  // The table starts at 1/16: below it a difference to the first entry would be larger than the result.
  const int k = q < 0.0625 ? 0 : static_cast<int>(q * 16 + 0.5);
  const double c = k * 0.0625;
  const double t = k == 0 ? q : (num - c * den) / (den + c * num);  // atan q = atan c + atan t, |t| <= 1/16
  const double z = t * t;
  const double tail =
      z *
      (-1.0 / 3 + z * (1.0 / 5 + z * (-1.0 / 7 + z * (1.0 / 9 + z * (-1.0 / 11 + z * (1.0 / 13 + z * (-1.0 / 15)))))));
  const DoubleDouble base = kAtan[static_cast<unsigned>(k)];
  const DoubleDouble sum = detail::two_sum(base.hi, t);
  return {sum.hi, sum.lo + (base.lo + t * tail)};
}

}  // namespace

SinCos sincos(double x) {
  if (!is_finite(x)) return {kNan, kNan};
  const Reduced r = reduce(fabs(x));
  const double s = sin_kernel(r.angle).hi, c = cos_kernel(r.angle).hi;
  const bool negative = sign_bit(x);
  switch (r.quadrant) {
    case 0:
      return {negative ? -s : s, c};
    case 1:
      return {negative ? -c : c, -s};
    case 2:
      return {negative ? s : -s, -c};
    default:
      return {negative ? c : -c, s};
  }
}

double sin(double x) { return sincos(x).sin; }
double cos(double x) { return sincos(x).cos; }

double tan(double x) {
  if (!is_finite(x)) return kNan;
  const Reduced r = reduce(fabs(x));
  DoubleDouble s = sin_kernel(r.angle), c = cos_kernel(r.angle);
  if ((r.quadrant & 1) != 0) {  // tan(pi/2 + a) = -cos a / sin a
    const DoubleDouble swap = s;
    s = {-c.hi, -c.lo}, c = swap;
  }
  const double q = s.hi / c.hi;
  const DoubleDouble back = two_product(q, c.hi);
  const double t = q + (((s.hi - back.hi) - back.lo) + (s.lo - q * c.lo)) / c.hi;
  return sign_bit(x) ? -t : t;
}

double atan(double x) {
  if (is_nan(x)) return kNan;
  const double a = fabs(x);
  if (a <= 1) {
    const DoubleDouble r = atan_ratio(a, 1);
    return copysign(r.hi + r.lo, x);
  }
  const DoubleDouble r = atan_ratio(1, a);  // pi/2 - atan(1/a)
  const DoubleDouble d = two_sum(kHalfPi.hi, -r.hi);
  return copysign(d.hi + (d.lo + (kHalfPi.lo - r.lo)), x);
}

double atan2(double y, double x) {
  if (is_nan(x) || is_nan(y)) return kNan;
  double ay = fabs(y), ax = fabs(x);
  if (!is_finite(ax) || !is_finite(ay)) {
    ay = is_finite(ay) ? 0 : 1;
    ax = is_finite(ax) ? 0 : 1;
  } else if (ax > 0x1p1000 || ay > 0x1p1000) {  // keep den + c * num finite
    ay *= 0x1p-10, ax *= 0x1p-10;
  } else if (ax < 0x1p-900 && ay < 0x1p-900) {  // keep num - c * den out of the subnormals
    ay *= 0x1p110, ax *= 0x1p110;
  }
  DoubleDouble r{0, 0};
  if (ay > ax) {
    const DoubleDouble a = atan_ratio(ax, ay);
    r = two_sum(kHalfPi.hi, -a.hi);
    r.lo += kHalfPi.lo - a.lo;
  } else if (ay > 0) {
    r = atan_ratio(ay, ax);
  }
  if (sign_bit(x)) {
    const DoubleDouble d = two_sum(kPiParts.hi, -r.hi);
    r = {d.hi, d.lo + (kPiParts.lo - r.lo)};
  }
  return copysign(r.hi + r.lo, y);
}

float atan2(float y, float x) {
  return canonical(static_cast<float>(atan2(static_cast<double>(y), static_cast<double>(x))));
}

double asin(double x) {
  if (!(fabs(x) <= 1)) return kNan;
  return atan2(x, sqrt((1 - x) * (1 + x)));
}

double acos(double x) {
  if (!(fabs(x) <= 1)) return kNan;
  return atan2(sqrt((1 - x) * (1 + x)), x);
}

}  // namespace sinew::math
