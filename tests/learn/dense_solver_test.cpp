#include "learn/dense_solver.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "math/elementary.hpp"
#include "math/hash.hpp"
#include "math/random.hpp"

namespace sinew::learn::dense_solver_test {
namespace {

struct System {
  std::vector<double> a, b, x;
  explicit System(std::size_t n, std::uint64_t seed) : a(n * n), b(n), x(n) {
    math::Random random(seed);
    for (double& v : a) v = random.normal();
    for (double& v : x) v = random.normal();
    for (std::size_t r = 0; r < n; ++r)
      for (std::size_t c = 0; c < n; ++c) b[r] += a[r * n + c] * x[c];
  }
};

TEST(DenseSolver, FindsTheSolutionOfRandomSystems) {
  for (const std::size_t n : {1u, 2u, 7u, 60u, 245u}) {
    System s(n, n);
    ASSERT_TRUE(solve_in_place(s.a, s.b)) << n;
    for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(s.b[i], s.x[i], 1e-8) << n;
  }
}

TEST(DenseSolver, PivotsWhereTheDiagonalIsZero) {
  std::vector<double> a{0, 2, 1, 0}, b{4, 3};
  ASSERT_TRUE(solve_in_place(a, b));
  EXPECT_EQ(b, (std::vector<double>{3, 2}));
}

TEST(DenseSolver, RefusesSingularAndUnboundedSystems) {
  std::vector<double> singular{1, 2, 2, 4}, b{1, 1};
  EXPECT_FALSE(solve_in_place(singular, b));
  std::vector<double> odd{1, 0, 0, math::kNan}, c{1, 1};
  EXPECT_FALSE(solve_in_place(odd, c));
  std::vector<double> none{0, 0, 0, 0}, d{1, 1};
  EXPECT_FALSE(solve_in_place(none, d));
}

TEST(DenseSolver, RefusesAMatrixOfAnotherShape) {
  std::vector<double> a(6), b(2);
  EXPECT_FALSE(solve_in_place(a, b));
}

/// The bits of one system, seen on x86-64; an order of sums that depended on the machine would change them.
TEST(DenseSolver, GivesTheSameBitsEverywhere) {
  System s(40, 40);
  ASSERT_TRUE(solve_in_place(s.a, s.b));
  const auto bytes = std::as_bytes(std::span(s.b));
  EXPECT_EQ(math::fnv1a64({reinterpret_cast<const char*>(bytes.data()), bytes.size()}), 18118959722358555380u);
}

}  // namespace
}  // namespace sinew::learn::dense_solver_test
