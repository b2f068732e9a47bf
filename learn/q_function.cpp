#include "learn/q_function.hpp"

#include <algorithm>
#include <cstdlib>

#include "math/elementary.hpp"

namespace sinew::learn {

Actions Actions::discrete(std::span<const double> values) {
  if (!(values.size() >= 2 && values.size() <= kMost)) std::abort();
  Actions a;
  std::copy(values.begin(), values.end(), a.value_.begin());
  a.values_ = values.size();
  return a;
}

Actions Actions::continuous(double low, double high) {
  if (!(low < high)) std::abort();
  Actions a;
  a.value_[0] = low, a.value_[1] = high;
  return a;
}

Actions::Columns Actions::at(double action) const noexcept {
  Columns c{};
  if (values_ == 0) {
    const double u = std::clamp(2 * (action - value_[0]) / (value_[1] - value_[0]) - 1, -1.0, 1.0);
    c[0] = 1, c[1] = u, c[2] = u * u;
    return c;
  }
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < values_; ++i)
    if (math::fabs(value_[i] - action) < math::fabs(value_[nearest] - action)) nearest = i;
  c[nearest] = 1;
  return c;
}

double QFunction::value(std::span<const double> state, double action) const noexcept {
  std::array<double, RadialBasis::kMostFeatures> features;
  basis_.at(state, features);
  const Actions::Columns columns = actions_.at(action);
  double sum = 0;
  for (std::size_t c = 0; c < actions_.columns(); ++c) {
    double column = 0;
    for (std::size_t f = 0; f < basis_.size(); ++f) column += weights_[c * basis_.size() + f] * features[f];
    sum += columns[c] * column;
  }
  return sum;
}

Choice QFunction::best(std::span<const double> state) const noexcept {
  std::array<double, RadialBasis::kMostFeatures> features;
  basis_.at(state, features);
  return best_of(features);
}

Choice QFunction::best_of(std::span<const double> features) const noexcept {
  Actions::Columns of{};
  const std::size_t columns = actions_.columns(), size = basis_.size();
  for (std::size_t c = 0; c < columns; ++c)
    for (std::size_t f = 0; f < size; ++f) of[c] += weights_[c * size + f] * features[f];
  if (actions_.is_discrete()) {
    std::size_t best = 0;
    for (std::size_t c = 1; c < columns; ++c)
      if (of[c] > of[best]) best = c;
    return {actions_.value_[best], of[best]};
  }
  const auto worth = [&](double u) { return of[0] + u * (of[1] + u * of[2]); };
  double u = 0;
  if (of[2] < 0)
    u = std::clamp(-0.5 * of[1] / of[2], -1.0, 1.0);
  else if (of[1] != 0 || of[2] > 0)  // it opens upwards, or is straight: an end
    u = of[1] < 0 ? -1 : 1;
  const double half = 0.5 * (actions_.value_[1] - actions_.value_[0]);
  return {actions_.value_[0] + half * (u + 1), worth(u)};
}

}  // namespace sinew::learn
