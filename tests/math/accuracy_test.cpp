// How far the elementary functions are from the true values. The reference is the C library in long double, so this
// only runs where long double has more bits than double.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "math/elementary.hpp"
#include "math/random.hpp"

namespace {

using namespace sinew;

/// |got - want| in units of the last place of the double nearest to want.
double ulps(double got, long double want) {
  const double near = static_cast<double>(want);
  if (std::isnan(near)) return std::isnan(got) ? 0 : 1e9;
  // Infinity represents the double after the largest one.
  const long double top = std::ldexp(1.0L, 1024);
  const auto finite = [&](long double v) { return std::fabs(v) < top ? v : std::copysign(top, v); };
  const int exponent = near == 0 ? -1022 : std::isinf(near) ? 1023 : std::max(std::ilogb(near), -1022);
  return static_cast<double>(std::fabs(finite(got) - finite(want)) / std::ldexp(1.0L, exponent - 52));
}

struct Worst {
  double ulp = 0, x = 0, y = 0;
  void add(double error, double x_, double y_ = 0) {
    if (error > ulp) *this = {error, x_, y_};
  }
};

void expect_within(const char* what, const Worst& worst, double limit) {
  std::printf("%-28s %.4f ULP at %a %a\n", what, worst.ulp, worst.x, worst.y);
  EXPECT_LE(worst.ulp, limit) << what << " at " << worst.x << ", " << worst.y;
  EXPECT_GT(worst.ulp, 0) << what << ": a reference that is never off is no reference";
}

/// Every sign, exponents spread evenly from low to high, random mantissa.
double spread(math::Random& random, int low_exponent, int high_exponent) {
  const double m = std::ldexp(
      random.uniform(1, 2),
      low_exponent + static_cast<int>(random.below(static_cast<std::uint32_t>(high_exponent - low_exponent + 1))));
  return (random.next_u32() & 1) != 0 ? -m : m;
}

constexpr int kPoints = 200000;

template <class Ours, class Reference, class Draw>
Worst worst_of(Ours ours, Reference reference, Draw draw, int points = kPoints) {
  Worst worst;
  for (int i = 0; i < points; ++i) {
    const double x = draw();
    worst.add(ulps(ours(x), reference(static_cast<long double>(x))), x);
  }
  return worst;
}

class Accuracy : public testing::Test {
 protected:
  void SetUp() override {
    if (std::numeric_limits<long double>::digits < 64) GTEST_SKIP() << "long double is no wider than double here";
  }
  math::Random random{20240701};
};

#define SINEW_OURS(f) [](double x) { return math::f(x); }
#define SINEW_REFERENCE(f) [](long double x) { return std::f(x); }

TEST_F(Accuracy, SineAndCosineWithinOneUlpOverTheWorkingRange) {
  const auto turn = [&] { return random.uniform(-7, 7); };
  expect_within("sin -7..7", worst_of(SINEW_OURS(sin), SINEW_REFERENCE(sin), turn), 1);
  expect_within("cos -7..7", worst_of(SINEW_OURS(cos), SINEW_REFERENCE(cos), turn), 1);
  const auto turns = [&] { return random.uniform(-1e6, 1e6); };
  expect_within("sin -1e6..1e6", worst_of(SINEW_OURS(sin), SINEW_REFERENCE(sin), turns), 1);
  expect_within("cos -1e6..1e6", worst_of(SINEW_OURS(cos), SINEW_REFERENCE(cos), turns), 1);
}

TEST_F(Accuracy, SineAndCosineWithinOneUlpForEveryExponent) {
  const auto any = [&] { return spread(random, -1022, 1023); };
  expect_within("sin any", worst_of(SINEW_OURS(sin), SINEW_REFERENCE(sin), any), 1);
  expect_within("cos any", worst_of(SINEW_OURS(cos), SINEW_REFERENCE(cos), any), 1);
}

TEST_F(Accuracy, SineAndCosineKeepTheirBitsBesideMultiplesOfHalfPi) {
  Worst s, c, t;
  for (int k = 1; k <= kPoints; ++k) {
    const double n = k <= kPoints / 2 ? k : std::floor(std::ldexp(random.uniform(1, 2), 17 + k % 60));
    double x = static_cast<double>(static_cast<long double>(n) * 1.57079632679489661923132169163975144L);
    const int steps = static_cast<int>(random.below(5)) - 2;
    for (int i = 0; i < std::abs(steps); ++i) x = std::nextafter(x, steps > 0 ? 1e300 : 0.0);
    s.add(ulps(math::sin(x), std::sin(static_cast<long double>(x))), x);
    c.add(ulps(math::cos(x), std::cos(static_cast<long double>(x))), x);
    t.add(ulps(math::tan(x), std::tan(static_cast<long double>(x))), x);
  }
  // The hardest argument of all for a double: 6381956970095103 * 2^797 is within 2^-61 of a multiple of pi/2.
  const double hardest = std::ldexp(6381956970095103.0, 797);
  s.add(ulps(math::sin(hardest), std::sin(static_cast<long double>(hardest))), hardest);
  c.add(ulps(math::cos(hardest), std::cos(static_cast<long double>(hardest))), hardest);
  expect_within("sin beside k pi/2", s, 1);
  expect_within("cos beside k pi/2", c, 1);
  expect_within("tan beside k pi/2", t, 1);
}

TEST_F(Accuracy, TangentWithinOneUlp) {
  expect_within("tan -7..7", worst_of(SINEW_OURS(tan), SINEW_REFERENCE(tan), [&] { return random.uniform(-7, 7); }), 1);
  expect_within("tan any", worst_of(SINEW_OURS(tan), SINEW_REFERENCE(tan), [&] { return spread(random, -1022, 1023); }),
                1);
}

TEST_F(Accuracy, ArcTangentWithinOneUlp) {
  expect_within("atan -4..4", worst_of(SINEW_OURS(atan), SINEW_REFERENCE(atan), [&] { return random.uniform(-4, 4); }),
                1);
  expect_within("atan any",
                worst_of(SINEW_OURS(atan), SINEW_REFERENCE(atan), [&] { return spread(random, -1022, 1023); }), 1);
}

TEST_F(Accuracy, Atan2WithinTwoUlpForAllMagnitudes) {
  Worst near, far;
  for (int i = 0; i < kPoints; ++i) {
    double y = random.uniform(-1, 1), x = random.uniform(-1, 1);
    near.add(ulps(math::atan2(y, x), std::atan2(static_cast<long double>(y), static_cast<long double>(x))), y, x);
    y = spread(random, -1022, 1023);
    x = i % 2 == 0 ? spread(random, -1022, 1023) : y * random.uniform(-30, 30);
    if (!std::isfinite(x)) continue;
    far.add(ulps(math::atan2(y, x), std::atan2(static_cast<long double>(y), static_cast<long double>(x))), y, x);
  }
  expect_within("atan2 -1..1", near, 2);
  expect_within("atan2 any", far, 2);
}

TEST_F(Accuracy, Atan2fIsTheRoundedTrueValue) {
  for (int i = 0; i < kPoints; ++i) {
    const float y = static_cast<float>(random.uniform(-1, 1)), x = static_cast<float>(random.uniform(-1, 1));
    const long double want = std::atan2(static_cast<long double>(y), static_cast<long double>(x));
    const float got = math::atan2(y, x);
    const float ulp = std::nextafter(std::fabs(got), 10.0F) - std::fabs(got);
    ASSERT_LE(std::fabs(static_cast<long double>(got) - want), 0.5000001L * ulp) << y << " " << x;
  }
}

TEST_F(Accuracy, ArcSineAndArcCosineWithinTwoUlp) {
  const auto inside = [&] { return random.uniform(-1, 1); };
  expect_within("asin", worst_of(SINEW_OURS(asin), SINEW_REFERENCE(asin), inside), 2);
  expect_within("acos", worst_of(SINEW_OURS(acos), SINEW_REFERENCE(acos), inside), 2);
  const auto near_one = [&] { return 1 - std::ldexp(random.uniform(), -static_cast<int>(random.below(53))); };
  expect_within("asin near 1", worst_of(SINEW_OURS(asin), SINEW_REFERENCE(asin), near_one), 2);
  expect_within("acos near 1", worst_of(SINEW_OURS(acos), SINEW_REFERENCE(acos), near_one), 2);
  const auto small = [&] { return spread(random, -1022, -1); };
  expect_within("asin small", worst_of(SINEW_OURS(asin), SINEW_REFERENCE(asin), small), 2);
}

TEST_F(Accuracy, ExponentialWithinOneUlp) {
  expect_within("exp -1..1", worst_of(SINEW_OURS(exp), SINEW_REFERENCE(exp), [&] { return random.uniform(-1, 1); }), 1);
  expect_within("exp all", worst_of(SINEW_OURS(exp), SINEW_REFERENCE(exp), [&] { return random.uniform(-747, 712); }),
                1);
  expect_within("exp subnormal",
                worst_of(SINEW_OURS(exp), SINEW_REFERENCE(exp), [&] { return random.uniform(-745.2, -708); }), 1);
  expect_within("exp small", worst_of(SINEW_OURS(exp), SINEW_REFERENCE(exp), [&] { return spread(random, -60, 0); }),
                1);
}

TEST_F(Accuracy, LogarithmWithinOneUlp) {
  expect_within("log 0.5..2", worst_of(SINEW_OURS(log), SINEW_REFERENCE(log), [&] { return random.uniform(0.5, 2); }),
                1);
  expect_within("log any",
                worst_of(SINEW_OURS(log), SINEW_REFERENCE(log), [&] { return std::fabs(spread(random, -1074, 1023)); }),
                1);
  expect_within("log beside 1",
                worst_of(SINEW_OURS(log), SINEW_REFERENCE(log), [&] { return 1 + spread(random, -52, -2); }), 1);
}

TEST_F(Accuracy, PowerWithinOneUlp) {
  Worst near, far, beside_one, roots;
  const auto check = [](Worst& worst, double x, double y) {
    worst.add(ulps(math::pow(x, y), std::pow(static_cast<long double>(x), static_cast<long double>(y))), x, y);
  };
  for (int i = 0; i < kPoints; ++i) {
    check(near, random.uniform(0.1, 10), random.uniform(-10, 10));
    const double x = std::fabs(spread(random, -1074, 1023));
    check(far, x, random.uniform(-760, 760) / std::log(x));
    check(beside_one, 1 + spread(random, -52, -3), spread(random, 0, 45));
    check(roots, random.uniform(-300, 300), static_cast<double>(static_cast<int>(random.below(41)) - 20));
  }
  expect_within("pow near", near, 1);
  expect_within("pow any", far, 1);
  expect_within("pow beside 1", beside_one, 1);
  expect_within("pow of integers", roots, 1);
}

TEST_F(Accuracy, HypotWithinTwoUlpForAllMagnitudes) {
  Worst worst;
  for (int i = 0; i < kPoints; ++i) {
    const double x = spread(random, -1074, 1022), y = x * random.uniform(-2, 2);
    worst.add(ulps(math::hypot(x, y), std::hypot(static_cast<long double>(x), static_cast<long double>(y))), x, y);
  }
  expect_within("hypot", worst, 2);
}

TEST(Exact, RootRoundingAndRemainderEqualTheCLibrary) {
  math::Random random(7);
  for (int i = 0; i < kPoints; ++i) {
    const double x = i % 2 == 0 ? spread(random, -1074, 1023) : std::round(2 * random.uniform(-9, 9)) / 2;
    const double y = i % 3 == 0 ? spread(random, -1074, 1023) : x * random.uniform(-3, 3);
    ASSERT_EQ(math::floor(x), std::floor(x)) << x;
    ASSERT_EQ(math::ceil(x), std::ceil(x)) << x;
    ASSERT_EQ(math::round(x), std::round(x)) << x;
    ASSERT_EQ(math::trunc(x), std::trunc(x)) << x;
    ASSERT_EQ(std::signbit(math::ceil(x)), std::signbit(std::ceil(x))) << x;
    ASSERT_EQ(std::signbit(math::round(x)), std::signbit(std::round(x))) << x;
    ASSERT_EQ(math::sqrt(std::fabs(x)), std::sqrt(std::fabs(x))) << x;
    if (y != 0) {
      ASSERT_EQ(math::fmod(x, y), std::fmod(x, y)) << x << " " << y;
    }
  }
}

}  // namespace
