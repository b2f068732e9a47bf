#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "learn/radial_basis.hpp"

namespace sinew::learn {

/// What may be done in a state: one of a few values, or any number between two.
/// Each way has columns, functions of the action alone: a discrete action has one for each value (1 there, 0
/// elsewhere), a continuous one has 1, u and u^2, where u is the action scaled to -1..1. So the best continuous action
/// of a state is the vertex of a parabola, or an end.
class Actions {
 public:
  static constexpr std::size_t kMost = 8;
  using Columns = std::array<double, kMost>;

  static Actions discrete(std::span<const double> values);  // 2 to kMost
  static Actions continuous(double low, double high);

  bool is_discrete() const { return values_ != 0; }
  std::size_t columns() const { return values_ != 0 ? values_ : 3; }
  /// Of a discrete action: the nearest value's.
  Columns at(double action) const noexcept;
  /// Discrete: of all values. Continuous: low and high.
  std::span<const double> values() const { return {value_.data(), values_ != 0 ? values_ : 2}; }

 private:
  friend class QFunction;
  std::array<double, kMost> value_{};
  std::size_t values_ = 0;  // 0: continuous
};

/// An action with what it is worth.
struct Choice {
  double action = 0, value = 0;
};

/// The expected sum of discounted rewards of an action in a state, linear in its weights: each radial basis function
/// times each column of the action has one.
/// Thread:  owner to make and to set weights, then any.   RT: value() and best() yes; they allocate nothing.
class QFunction {
 public:
  QFunction(const RadialBasis& basis, const Actions& actions)
      : basis_(basis), actions_(actions), weights_(basis.size() * actions.columns()) {}

  const RadialBasis& basis() const { return basis_; }
  const Actions& actions() const { return actions_; }
  /// Column by column; in each, those of the basis in its order.
  std::span<const double> weights() const { return weights_; }
  std::span<double> weights() { return weights_; }

  double value(std::span<const double> state, double action) const noexcept;
  /// The best action; of equal ones the first of the values, of a level parabola the middle.
  Choice best(std::span<const double> state) const noexcept;
  /// The same from the features of the state.
  Choice best_of(std::span<const double> features) const noexcept;

 private:
  RadialBasis basis_;
  Actions actions_;
  std::vector<double> weights_;
};

}  // namespace sinew::learn
