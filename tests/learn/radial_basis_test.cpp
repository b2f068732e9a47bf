#include "learn/radial_basis.hpp"

#include <gtest/gtest.h>

#include <numeric>

namespace sinew::learn::radial_basis_test {
namespace {

constexpr GridAxis kPlane[] = {{0, 2, 3}, {-1, 1, 5}};

std::vector<double> features(const RadialBasis& basis, std::vector<double> state) {
  std::vector<double> f(basis.size());
  basis.at(state, f);
  return f;
}

TEST(RadialBasis, HasAFeatureForEachCrossing) {
  EXPECT_EQ(RadialBasis(kPlane).size(), 15u);
  EXPECT_EQ(RadialBasis().size(), 1u);
  EXPECT_EQ(features(RadialBasis(), {}), std::vector<double>{1});
}

TEST(RadialBasis, SumsUpToOneInsideAndOutsideOfTheGrid) {
  const RadialBasis basis(kPlane);
  for (const double x : {-5.0, 0.0, 0.3, 1.1, 2.0, 9.0})
    for (const double y : {-3.0, -0.2, 0.77, 4.0}) {
      const auto f = features(basis, {x, y});
      EXPECT_NEAR(std::accumulate(f.begin(), f.end(), 0.0), 1, 1e-12);
    }
}

TEST(RadialBasis, PeaksAtItsOwnCentreWithTheLastAxisFastest) {
  const RadialBasis basis(kPlane);
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = 0; k < 5; ++k) {
      const auto f = features(basis, {double(i), -1 + 0.5 * double(k)});
      EXPECT_EQ(std::max_element(f.begin(), f.end()) - f.begin(), long(i * 5 + k));
    }
}

TEST(RadialBasis, CountsAStateBeyondTheGridAsItsEnd) {
  const RadialBasis basis(kPlane);
  EXPECT_EQ(features(basis, {-7, 8}), features(basis, {0, 1}));
}

}  // namespace
}  // namespace sinew::learn::radial_basis_test
