#include "learn/q_function.hpp"

#include <gtest/gtest.h>

namespace sinew::learn::q_function_test {
namespace {

constexpr GridAxis kLine[] = {{0, 1, 2}};
constexpr double kThree[] = {-1, 0, 0.5};

QFunction discrete() { return {RadialBasis(kLine), Actions::discrete(kThree)}; }
QFunction continuous() { return {RadialBasis(kLine), Actions::continuous(-2, 4)}; }

/// The same parabola a + b u + c u^2 in every state.
QFunction parabola(double a, double b, double c) {
  QFunction q = continuous();
  for (std::size_t f = 0; f < 2; ++f) q.weights()[f] = a, q.weights()[2 + f] = b, q.weights()[4 + f] = c;
  return q;
}

TEST(QFunction, ChoosesTheBestOfDiscreteActionsByState) {
  QFunction q = discrete();
  q.weights()[1 * 2 + 0] = 3;  // action 0 is good at the lower end
  q.weights()[2 * 2 + 1] = 5;  // 0.5 at the upper one
  const double low[] = {0.0}, high[] = {1.0};
  EXPECT_EQ(q.best(low).action, 0);
  EXPECT_EQ(q.best(high).action, 0.5);
  EXPECT_NEAR(q.best(high).value, q.value(high, 0.5), 1e-12);
}

TEST(QFunction, TakesTheFirstOfEqualActions) {
  const double any[] = {0.4};
  EXPECT_EQ(discrete().best(any).action, -1);
}

TEST(QFunction, TakesTheVertexOfAParabolaThatOpensDownwards) {
  const double any[] = {0.4};
  const QFunction q = parabola(1, 0.5, -0.5);  // vertex at u = 0.5: 0.75 of the way from -2 to 4
  EXPECT_NEAR(q.best(any).action, 2.5, 1e-12);
  EXPECT_NEAR(q.best(any).value, 1.125, 1e-12);
  EXPECT_NEAR(q.value(any, 2.5), 1.125, 1e-12);
}

TEST(QFunction, TakesAnEndWhereTheVertexIsOutsideOrNoMaximum) {
  const double any[] = {0.4};
  EXPECT_EQ(parabola(0, 5, -1).best(any).action, 4);
  EXPECT_EQ(parabola(0, -5, -1).best(any).action, -2);
  EXPECT_EQ(parabola(0, 0.1, 1).best(any).action, 4);
  EXPECT_EQ(parabola(0, -0.1, 1).best(any).action, -2);
  EXPECT_EQ(parabola(0, 0, 0).best(any).action, 1);  // level: the middle
}

TEST(QFunction, ActionsBeyondTheRangeCountAsItsEnd) {
  EXPECT_EQ(Actions::continuous(-2, 4).at(99), Actions::continuous(-2, 4).at(4));
  EXPECT_EQ(Actions::discrete(kThree).at(99), Actions::discrete(kThree).at(0.5));
}

}  // namespace
}  // namespace sinew::learn::q_function_test
