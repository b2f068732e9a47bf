#include "learn/lstd_q.hpp"

#include <gtest/gtest.h>

#include "math/random.hpp"

namespace sinew::learn::lstd_q_test {
namespace {

constexpr double kSteps[] = {-1, 0, 1};

TEST(LstdQ, ValuesARewardThatComesForEverAtTheSumOfItsSeries) {
  LstdQ sums(2);  // no state, two actions
  const double one[] = {1};
  for (int i = 0; i < 10; ++i) sums.add(one, {1, 0}, one, {1, 0}, 0.9, 2);
  double w[2] = {};
  ASSERT_TRUE(sums.solve(1e-9, 0, w));
  EXPECT_NEAR(w[0], 20, 1e-5);  // 2 / (1 - 0.9)
  EXPECT_EQ(w[1], 0);           // never tried: the prior
}

TEST(LstdQ, ValuesTheLastDecisionAtItsReward) {
  LstdQ sums(2);
  const double one[] = {1};
  sums.add(one, {0, 1}, {}, {}, 0.9, -3);
  double w[2] = {};
  ASSERT_TRUE(sums.solve(1e-9, 7, w));
  EXPECT_NEAR(w[0], 7, 1e-9);
  EXPECT_NEAR(w[1], -3, 1e-6);
}

TEST(LstdQ, AddsWholeOuterProductsForContinuousActions) {
  // Against the plain formula: A += f (f - g f')^T with f = columns x basis.
  const std::vector<double> basis{0.3, 0.7}, next{0.6, 0.4};
  const Actions::Columns c{1, 0.5, 0.25}, d{1, -1, 1};
  LstdQ sums(6);
  sums.add(basis, c, next, d, 0.8, 1.5);
  std::vector<double> f, g;
  for (int k = 0; k < 3; ++k)
    for (std::size_t i = 0; i < 2; ++i) f.push_back(c[k] * basis[i]), g.push_back(d[k] * next[i]);
  // A w = b with a ridge of 1: (f (f - 0.8 g)^T + 1) w = 1.5 f has w = s f, s = 1.5 / (1 + (f - 0.8 g) f).
  double product = 0;
  for (std::size_t i = 0; i < 6; ++i) product += (f[i] - 0.8 * g[i]) * f[i];
  std::vector<double> w(6);
  ASSERT_TRUE(sums.solve(1, 0, w));
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(w[i], 1.5 / (1 + product) * f[i], 1e-12);
}

/// A walker on a line of unit length, each step costs, at the upper end it is done.
class Walk {
 public:
  explicit Walk(const Actions& actions) : q(RadialBasis(kAxis), actions) {}
  void random_walks(PolicyIteration& learner, std::uint64_t seed) {
    math::Random random(seed);
    for (int walk = 0; walk < 100; ++walk) {
      double x = random.uniform();
      for (int step = 0; step < 20 && x < 0.95; ++step) {
        Transition t;
        t.state[0] = x;
        t.action = random.uniform(-1, 1);
        if (q.actions().is_discrete()) t.action = kSteps[random.below(3)];
        x = std::max(0.0, x + 0.1 * t.action);
        t.next[0] = x;
        t.reward = -1;
        t.last = x >= 0.95;
        learner.add(t);
      }
    }
  }
  double action(double x) { return q.best(std::span(&x, 1)).action; }

  QFunction q;

 private:
  static constexpr GridAxis kAxis[] = {{0, 1, 8}};
};

TEST(PolicyIteration, FindsTheWayFromRandomWalks) {
  Walk walk(Actions::discrete(kSteps));
  PolicyIteration learner(walk.q);
  walk.random_walks(learner, 1);
  const auto result = learner.improve(walk.q, {.discount = 0.95, .ridge = 0.01});
  EXPECT_TRUE(result.settled);
  for (const double x : {0.05, 0.4, 0.9}) EXPECT_EQ(walk.action(x), 1) << x;
}

TEST(PolicyIteration, FindsItWithContinuousActions) {
  Walk walk(Actions::continuous(-1, 1));
  PolicyIteration learner(walk.q);
  walk.random_walks(learner, 1);
  learner.improve(walk.q, {.discount = 0.95, .ridge = 0.01});
  for (const double x : {0.05, 0.4, 0.9}) EXPECT_GT(walk.action(x), 0.8) << x;
}

TEST(PolicyIteration, GivesTheSameBytesForTheSameTransitions) {
  Walk one(Actions::continuous(-1, 1)), other(Actions::continuous(-1, 1));
  PolicyIteration a(one.q), b(other.q);
  one.random_walks(a, 3);
  other.random_walks(b, 3);
  a.improve(one.q, {});
  b.improve(other.q, {});
  EXPECT_TRUE(std::equal(one.q.weights().begin(), one.q.weights().end(), other.q.weights().begin()));
}

TEST(PolicyIteration, KeepsTheWeightsWhenNothingCanBeSolved) {
  Walk walk(Actions::discrete(kSteps));
  walk.q.weights()[0] = 4;
  PolicyIteration learner(walk.q);
  const auto result = learner.improve(walk.q, {.ridge = 0});  // no transitions, no ridge: singular
  EXPECT_FALSE(result.settled);
  EXPECT_EQ(walk.q.weights()[0], 4);
}

}  // namespace
}  // namespace sinew::learn::lstd_q_test
