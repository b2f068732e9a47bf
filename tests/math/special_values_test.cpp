// Limits, zeros, infinities and NaN.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "math/convert.hpp"
#include "math/elementary.hpp"

namespace {

using namespace sinew;

constexpr double kInf = math::kInf;
constexpr double kMax = std::numeric_limits<double>::max();
constexpr double kTiny = std::numeric_limits<double>::denorm_min();

std::uint64_t bits_of(double x) { return std::bit_cast<std::uint64_t>(x); }
constexpr std::uint64_t kNanBits = 0x7ff8000000000000;

double negative_nan() { return std::bit_cast<double>(std::uint64_t{0xfff8000000000123}); }

TEST(SpecialValues, EveryNanThatComesOutIsTheCanonicalOne) {
  const double n = negative_nan();
  for (const double v :
       {math::sin(n), math::cos(n), math::tan(n), math::asin(n), math::acos(n), math::atan(n), math::exp(n),
        math::log(n), math::sqrt(n), math::trunc(n), math::floor(n), math::ceil(n), math::round(n), math::canonical(n),
        math::atan2(n, 1.0), math::atan2(1.0, n), math::pow(n, 1), math::pow(2, n), math::hypot(n, 1), math::fmod(n, 1),
        math::fmod(1, n), math::wrap_pi(n), math::sincos(n).cos,
        // and from what has no value
        math::sin(kInf), math::cos(-kInf), math::tan(kInf), math::asin(1.0000001), math::acos(-2), math::log(-1),
        math::log(-kInf), math::sqrt(-1.0), math::sqrt(-kTiny), math::pow(-2, 0.5), math::fmod(1, 0),
        math::fmod(kInf, 1), math::wrap_pi(kInf)})
    EXPECT_EQ(bits_of(v), kNanBits);
  EXPECT_EQ(std::bit_cast<std::uint32_t>(math::canonical(std::bit_cast<float>(0xffc00001u))), 0x7fc00000u);
  EXPECT_EQ(std::bit_cast<std::uint32_t>(math::sqrt(-1.0F)), 0x7fc00000u);
  EXPECT_EQ(std::bit_cast<std::uint32_t>(math::atan2(std::bit_cast<float>(0xffc00001u), 1.0F)), 0x7fc00000u);
}

TEST(SpecialValues, LimitsAreThoseOfTheCStandard) {
  const double values[] = {0.0, -0.0,  1,      -1,   0.5,   -0.5,  2,      -2,   3,
                           -3,  1e300, -1e300, kMax, -kMax, kTiny, -kTiny, kInf, -kInf};
  const auto same = [](double got, double want, const char* what, double a, double b = 0) {
    const bool close = got == want || std::fabs(got - want) <= 1e-15 * std::fabs(want);
    const bool ok = std::isnan(want) ? bits_of(got) == kNanBits : close && std::signbit(got) == std::signbit(want);
    EXPECT_TRUE(ok) << what << " " << a << " " << b << ": " << got << ", not " << want;
  };
  for (const double a : values) {
    same(math::sin(a), std::sin(a), "sin", a);
    same(math::cos(a), std::cos(a), "cos", a);
    same(math::tan(a), std::tan(a), "tan", a);
    same(math::atan(a), std::atan(a), "atan", a);
    same(math::exp(a), std::exp(a), "exp", a);
    same(math::log(a), std::log(a), "log", a);
    same(math::asin(a), std::asin(a), "asin", a);
    same(math::acos(a), std::acos(a), "acos", a);
    same(math::trunc(a), std::trunc(a), "trunc", a);
    same(math::floor(a), std::floor(a), "floor", a);
    same(math::ceil(a), std::ceil(a), "ceil", a);
    same(math::round(a), std::round(a), "round", a);
    same(math::sqrt(a), std::sqrt(a), "sqrt", a);
    for (const double b : values) {
      same(math::atan2(a, b), std::atan2(a, b), "atan2", a, b);
      same(math::pow(a, b), std::pow(a, b), "pow", a, b);
      same(math::hypot(a, b), std::hypot(a, b), "hypot", a, b);
      same(math::fmod(a, b), std::fmod(a, b), "fmod", a, b);
    }
  }
  const double n = negative_nan();
  EXPECT_EQ(math::pow(n, 0), 1);
  EXPECT_EQ(math::pow(1, n), 1);
  EXPECT_EQ(math::hypot(n, kInf), kInf);
}

TEST(SpecialValues, RoundingKnowsTheNeighboursOfHalf) {
  EXPECT_EQ(math::round(0.49999999999999994), 0);
  EXPECT_EQ(math::round(-2.5), -3);
  EXPECT_EQ(math::round(4503599627370495.5), 4503599627370496.0);
  EXPECT_EQ(math::floor(-kTiny), -1);
  EXPECT_TRUE(std::signbit(math::ceil(-0.5)));
  static_assert(math::floor(-1.5) == -2 && math::round(2.5) == 3 && math::trunc(-1.5) == -1);
}

TEST(SpecialValues, WrapBringsAnglesIntoOneTurn) {
  EXPECT_EQ(math::wrap_pi(math::kPi), math::kPi);
  EXPECT_NEAR(math::wrap_pi(7), 7 - 2 * math::kPi, 1e-15);
  EXPECT_NEAR(math::wrap_pi(-3.5 * math::kPi), 0.5 * math::kPi, 1e-14);
}

TEST(ToInteger, SaturatesAndGivesZeroForNan) {
  using math::to_integer;
  EXPECT_EQ(to_integer<std::int32_t>(1.9), 1);
  EXPECT_EQ(to_integer<std::int32_t>(-1.9), -1);
  EXPECT_EQ(to_integer<std::int32_t>(2147483647.5), 2147483647);
  EXPECT_EQ(to_integer<std::int32_t>(2147483648.0), 2147483647);
  EXPECT_EQ(to_integer<std::int32_t>(-2147483648.9), -2147483647 - 1);
  EXPECT_EQ(to_integer<std::int32_t>(-kInf), -2147483647 - 1);
  EXPECT_EQ(to_integer<std::int32_t>(negative_nan()), 0);
  EXPECT_EQ(to_integer<std::uint8_t>(255.99), 255);
  EXPECT_EQ(to_integer<std::uint8_t>(256.0), 255);
  EXPECT_EQ(to_integer<std::uint8_t>(-0.5), 0);
  EXPECT_EQ(to_integer<std::uint8_t>(-7.0), 0);
  EXPECT_EQ(to_integer<std::int64_t>(9223372036854774784.0), 9223372036854774784);
  EXPECT_EQ(to_integer<std::int64_t>(9223372036854775808.0), std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(to_integer<std::int64_t>(-1e300), std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(to_integer<std::uint64_t>(18446744073709549568.0), 18446744073709549568u);
  EXPECT_EQ(to_integer<std::uint64_t>(kInf), std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(to_integer<std::int16_t>(-40000.0), -32768);
}

}  // namespace
