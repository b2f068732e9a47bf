#include "identify/dense.hpp"

#include <gtest/gtest.h>

#include "identify/student.hpp"
#include "math/elementary.hpp"
#include "math/random.hpp"

namespace sinew::identify::dense_test {
namespace {

Dense random_positive(std::size_t n, std::uint64_t seed) {
  math::Random random(seed);
  Dense root(n, n), a(n, n);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) root(i, j) = random.normal();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j)
      for (std::size_t k = 0; k < n; ++k) a(i, j) += root(i, k) * root(j, k);
  return a;
}

TEST(Dense, TheInverseOfAPositiveMatrixTimesItIsOne) {
  const Dense a = random_positive(9, 1);
  const auto inverse = inverse_of_positive(a);
  ASSERT_TRUE(inverse);
  for (std::size_t i = 0; i < 9; ++i)
    for (std::size_t j = 0; j < 9; ++j) {
      double sum = 0;
      for (std::size_t k = 0; k < 9; ++k) sum += a(i, k) * (*inverse)(k, j);
      EXPECT_NEAR(sum, i == j ? 1 : 0, 1e-8);
    }
}

TEST(Dense, WhatIsNotPositiveHasNoInverse) {
  Dense a = random_positive(4, 2);
  for (std::size_t i = 0; i < 4; ++i) a(i, 2) = a(2, i) = 0;
  EXPECT_FALSE(inverse_of_positive(a));
  a(2, 2) = math::kNan;
  EXPECT_FALSE(solve_positive(a, {1, 2, 3, 4}));
}

TEST(Dense, EigenvaluesRiseAndTheirVectorsGiveTheMatrixBack) {
  const Dense a = random_positive(8, 3);
  const SymmetricEigen e = symmetric_eigen(a);
  for (std::size_t i = 1; i < 8; ++i) EXPECT_LE(e.values[i - 1], e.values[i]);
  for (std::size_t i = 0; i < 8; ++i)
    for (std::size_t j = 0; j < 8; ++j) {
      double sum = 0;
      for (std::size_t k = 0; k < 8; ++k) sum += e.vectors(i, k) * e.values[k] * e.vectors(j, k);
      EXPECT_NEAR(sum, a(i, j), 1e-10);
    }
}

TEST(Student, HasTheQuantilesOfTheTables) {
  EXPECT_NEAR(student_95(1), 12.706, 0.01);
  EXPECT_NEAR(student_95(2), 4.303, 0.01);
  EXPECT_NEAR(student_95(3), 3.182, 0.03);
  EXPECT_NEAR(student_95(7), 2.365, 0.002);
  EXPECT_NEAR(student_95(30), 2.042, 0.001);
  EXPECT_NEAR(student_95(1e6), 1.960, 0.001);
}

}  // namespace
}  // namespace sinew::identify::dense_test
