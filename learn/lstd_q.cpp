#include "learn/lstd_q.hpp"

#include <algorithm>

#include "learn/dense_solver.hpp"
#include "math/elementary.hpp"

namespace sinew::learn {

void LstdQ::clear() {
  std::fill(a_.begin(), a_.end(), 0.0);
  std::fill(b_.begin(), b_.end(), 0.0);
}

void LstdQ::add(std::span<const double> basis, const Actions::Columns& columns, std::span<const double> next,
                const Actions::Columns& next_columns, double discount, double reward) noexcept {
  const std::size_t size = basis.size(), n = b_.size(), blocks = n / size;
  std::array<double, RadialBasis::kMostFeatures> change;
  for (std::size_t to = 0; to < blocks; ++to) {
    const double now = columns[to], then = next.empty() ? 0 : discount * next_columns[to];
    if (now == 0 && then == 0) continue;
    if (then == 0)
      for (std::size_t f = 0; f < size; ++f) change[f] = now * basis[f];
    else
      for (std::size_t f = 0; f < size; ++f) change[f] = now * basis[f] - then * next[f];
    for (std::size_t of = 0; of < blocks; ++of) {
      if (columns[of] == 0) continue;
      for (std::size_t r = 0; r < size; ++r) {
        const double factor = columns[of] * basis[r];
        double* __restrict const row = a_.data() + (of * size + r) * n + to * size;
        for (std::size_t f = 0; f < size; ++f) row[f] += factor * change[f];
      }
    }
  }
  for (std::size_t of = 0; of < blocks; ++of)
    if (columns[of] != 0)
      for (std::size_t f = 0; f < size; ++f) b_[of * size + f] += columns[of] * basis[f] * reward;
}

bool LstdQ::solve(double ridge, double prior, std::span<double> weights) const {
  const std::size_t n = b_.size();
  std::vector<double> a(a_), b(b_);
  for (std::size_t i = 0; i < n; ++i) {
    a[i * n + i] += ridge;
    b[i] += ridge * prior;
  }
  if (!solve_in_place(a, b)) return false;
  std::copy(b.begin(), b.end(), weights.begin());
  return true;
}

void PolicyIteration::add(const Transition& t) {
  const std::size_t size = basis_.size(), begin = features_.size();
  features_.resize(begin + 2 * size);
  basis_.at(t.state, std::span(features_).subspan(begin, size));
  basis_.at(t.next, std::span(features_).subspan(begin + size, size));
  all_.push_back({actions_.at(t.action), t.reward, t.last});
}

PolicyIteration::Result PolicyIteration::improve(QFunction& q, const LearnOptions& options) {
  const std::size_t size = basis_.size();
  Result result;
  std::vector<double> weights(q.weights().size());
  while (result.iterations < options.most_iterations && !result.settled) {
    ++result.iterations;
    sums_.clear();
    for (std::size_t i = 0; i < all_.size(); ++i) {
      const auto now = std::span(features_).subspan(2 * i * size, size);
      const auto next = std::span(features_).subspan((2 * i + 1) * size, size);
      if (all_[i].last)
        sums_.add(now, all_[i].columns, {}, {}, 0, all_[i].reward);
      else
        sums_.add(now, all_[i].columns, next, actions_.at(q.best_of(next).action), options.discount, all_[i].reward);
    }
    if (!sums_.solve(options.ridge, options.prior, weights)) return result;
    double change = 0;
    for (std::size_t w = 0; w < weights.size(); ++w) change = std::max(change, math::fabs(weights[w] - q.weights()[w]));
    std::copy(weights.begin(), weights.end(), q.weights().begin());
    result.settled = change < options.settled;
  }
  return result;
}

}  // namespace sinew::learn
