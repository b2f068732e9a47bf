#include "vision/elementary_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "images.hpp"

namespace sinew::vision::elementary_motion_test {
namespace {

using msg::PixelFormat;
using test::Pixels;

Pixels noise(std::uint32_t width, std::uint32_t height, std::uint64_t seed, std::uint32_t slack = 0) {
  Pixels p(PixelFormat::mono8, width, height, slack);
  test::fill_noise(p.bytes().data(), p.bytes().size(), seed);
  return p;
}

struct Polar {
  std::vector<float> magnitude, direction;
};

Polar polar(const Pixels& a, const Pixels& b, Simd simd) {
  const std::size_t n = std::size_t{a.view().width} * a.view().height;
  Polar out{std::vector<float>(n, -7.0f), std::vector<float>(n, -7.0f)};
  correlate_polar(a.view(), b.view(), out.magnitude.data(), out.direction.data(), simd);
  return out;
}

// Sizes around the block of 16 pixels, and real ones.
const std::pair<std::uint32_t, std::uint32_t> kSizes[] = {{2, 2},   {5, 3},    {16, 4},   {17, 5},   {18, 5},  {31, 7},
                                                          {32, 9},  {33, 9},   {47, 11},  {48, 11},  {49, 12}, {64, 20},
                                                          {97, 33}, {320, 24}, {752, 20}, {1280, 10}};

TEST(ElementaryMotion, FollowsTheFourEquations) {
  const Pixels a = noise(37, 21, 1), b = noise(37, 21, 2);
  const Polar p = polar(a, b, Simd::scalar);
  for (std::uint32_t y = 0; y < 20; ++y)
    for (std::uint32_t x = 0; x < 36; ++x) {
      const auto at = [&](const Pixels& f, std::uint32_t dx, std::uint32_t dy) {
        return double{f.view().row(y + dy)[x + dx] * 1.0};
      };
      const double mx = at(b, 0, 0) * at(a, 1, 0) - at(a, 0, 0) * at(b, 1, 0);
      const double my = at(b, 0, 0) * at(a, 0, 1) - at(a, 0, 0) * at(b, 0, 1);
      const std::size_t i = y * 37 + x;
      EXPECT_NEAR(p.magnitude[i], std::hypot(mx, my), 1e-6 * std::hypot(mx, my));
      if (mx != 0 || my != 0) {
        const double off = std::remainder(p.direction[i] - std::atan2(my, mx), 2 * M_PI);
        EXPECT_NEAR(off, 0, 2e-4) << mx << ' ' << my;
      }
    }
}

TEST(ElementaryMotion, LastRowAndColumnStayUntouched) {
  const Pixels a = noise(35, 6, 1), b = noise(35, 6, 2);
  for (const Simd simd : {Simd::scalar, best_simd()}) {
    const Polar p = polar(a, b, simd);
    for (std::uint32_t y = 0; y < 6; ++y)
      for (std::uint32_t x = 0; x < 35; ++x)
        EXPECT_EQ(p.magnitude[y * 35 + x] == -7.0f, y == 5 || x == 34) << x << ' ' << y;
  }
}

TEST(ElementaryMotion, SimdGivesTheBitsOfTheScalarKernel) {
  if (best_simd() == Simd::scalar) GTEST_SKIP() << "this processor has no SIMD kernel";
  for (const auto& [width, height] : kSizes) {
    const Pixels a = noise(width, height, 3, 7), b = noise(width, height, 4, 7);
    const Polar s = polar(a, b, Simd::scalar), v = polar(a, b, best_simd());
    const std::size_t bytes = s.magnitude.size() * sizeof(float);
    EXPECT_EQ(std::memcmp(s.magnitude.data(), v.magnitude.data(), bytes), 0) << width;
    EXPECT_EQ(std::memcmp(s.direction.data(), v.direction.data(), bytes), 0) << width;
    EXPECT_EQ(correlate_sums(a.view(), b.view(), Simd::scalar), correlate_sums(a.view(), b.view(), best_simd()));
  }
}

TEST(ElementaryMotion, SimdCellsEqualScalarCellsWhereverTheyLie) {
  math::Random random(9);
  const Pixels a = noise(300, 200, 5, 3), b = noise(300, 200, 6, 3);
  for (int i = 0; i < 300; ++i) {
    PixelRect r;
    r.x0 = 1 + random.below(260), r.y0 = 1 + random.below(190);
    r.x1 = std::min(299u, r.x0 + 1 + random.below(kMaxCell)), r.y1 = std::min(199u, r.y0 + 1 + random.below(kMaxCell));
    EXPECT_EQ(correlate_cell(a.view(), b.view(), r, Simd::scalar), correlate_cell(a.view(), b.view(), r, best_simd()));
  }
}

// Extremes of the grey values on the largest image: sums of 32-bit lanes must not overflow.
TEST(ElementaryMotion, SumsDoNotOverflowOnTheLargestAndBrightestImage) {
  Pixels a(PixelFormat::mono8, 1280, 960), b(PixelFormat::mono8, 1280, 960);
  for (std::uint32_t y = 0; y < 960; ++y)
    for (std::uint32_t x = 0; x < 1280; ++x) {
      // Columns 255 0 255 0 that are lit in turn: x2 * x1' is the largest product, x1 * x2' is 0.
      a.row(y)[x] = x % 2 ? 255 : 0;
      b.row(y)[x] = x % 2 ? 0 : 255;
    }
  const CorrelatorSums scalar = correlate_sums(a.view(), b.view(), Simd::scalar);
  EXPECT_EQ(scalar.x, std::int64_t{65025} * 959 * 640 - std::int64_t{65025} * 959 * 639);
  EXPECT_EQ(correlate_sums(a.view(), b.view()), scalar);
  Pixels c(PixelFormat::mono8, 1280, 960), d(PixelFormat::mono8, 1280, 960);
  for (std::uint32_t y = 0; y < 960; ++y)
    for (std::uint32_t x = 0; x < 1280; ++x) c.row(y)[x] = y % 2 ? 0 : 255, d.row(y)[x] = 255;
  EXPECT_EQ(correlate_sums(c.view(), d.view()), correlate_sums(c.view(), d.view(), Simd::scalar));
  const PixelRect whole{1, 1, 1 + kMaxCell, 1 + kMaxCell};
  EXPECT_EQ(correlate_cell(a.view(), b.view(), whole), correlate_cell(a.view(), b.view(), whole, Simd::scalar));
  EXPECT_EQ(correlate_cell(c.view(), d.view(), whole), correlate_cell(c.view(), d.view(), whole, Simd::scalar));
}

TEST(ElementaryMotion, ABrightnessFactorAloneIsNoMotion) {
  Pixels a = noise(100, 50, 8), b(PixelFormat::mono8, 100, 50);
  for (auto& v : a.bytes()) v /= 2;
  for (std::size_t i = 0; i < a.bytes().size(); ++i) b.bytes()[i] = static_cast<std::uint8_t>(2 * a.bytes()[i]);
  EXPECT_EQ(correlate_sums(a.view(), b.view()), CorrelatorSums{});
}

}  // namespace
}  // namespace sinew::vision::elementary_motion_test
