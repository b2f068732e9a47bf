#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "learn/q_function.hpp"

namespace sinew::learn {

/// One decision and what came of it.
struct Transition {
  std::array<double, RadialBasis::kMostAxes> state{}, next{};
  double action = 0;
  double reward = 0;
  bool last = false;  // the episode ended with it: `next` has no worth
};

struct LearnOptions {
  double discount = 0.97;  // of the rewards of the next decision
  /// Regularisation: each weight is drawn to `prior` as strongly as by `ridge` decisions with its feature alone. It
  /// decides what a state is worth in which an action was never tried.
  double ridge = 0.05, prior = 0;
  int most_iterations = 10;
  double settled = 1e-3;  // the weights change by less: the policy is found
};

/// Least-squares temporal differences of a Q function: the sums of A w = b.
/// Source:  M. Lagoudakis and R. Parr, Least-squares policy iteration, JMLR 4 (2003), section 5.1 (LSTDQ).
/// Shape:   A is n x n, row-major, n = the number of weights.
/// Thread:  owner.
class LstdQ {
 public:
  explicit LstdQ(std::size_t weights) : a_(weights * weights), b_(weights) {}

  void clear();
  /// Adds f (f - discount * f')^T to A and f * reward to b, where f and f' are basis x columns of the decision and of
  /// the one that the policy takes next. Only blocks with a column that is not 0 are touched. `next` empty: the last
  /// decision. RT: yes.
  void add(std::span<const double> basis, const Actions::Columns& columns, std::span<const double> next,
           const Actions::Columns& next_columns, double discount, double reward) noexcept;
  /// The weights of (A + ridge) w = b + ridge * prior. False: singular, or not finite; `weights` is then as it was.
  bool solve(double ridge, double prior, std::span<double> weights) const;

 private:
  std::vector<double> a_, b_;
};

/// Least-squares policy iteration: evaluates the greedy policy of a Q function on transitions that any policy has made,
/// and takes the result as the next Q function, until the weights settle.
/// Source:  the same paper, figure 8.
/// Thread:  owner.
class PolicyIteration {
 public:
  explicit PolicyIteration(const QFunction& q) : basis_(q.basis()), actions_(q.actions()), sums_(q.weights().size()) {}

  void add(const Transition& transition);
  std::size_t size() const { return all_.size(); }

  struct Result {
    int iterations = 0;
    bool settled = false;
  };
  /// Improves `q`, beginning with its weights. Not settled: the iterations are used up, or the sums could not be
  /// solved; `q` is then the last that could.
  Result improve(QFunction& q, const LearnOptions& options);

 private:
  struct Kept {
    Actions::Columns columns{};
    double reward = 0;
    bool last = false;
  };
  RadialBasis basis_;
  Actions actions_;
  std::vector<Kept> all_;
  std::vector<double> features_;  // of state and next of each
  LstdQ sums_;
};

}  // namespace sinew::learn
