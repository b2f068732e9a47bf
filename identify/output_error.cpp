#include "identify/output_error.hpp"

#include <algorithm>

#include "identify/robust.hpp"
#include "identify/student.hpp"
#include "math/elementary.hpp"

namespace sinew::identify {
namespace {

class Fitter {
 public:
  Fitter(const OutputProblem& problem, std::span<const FreeParameter> parameters, const OutputFitOptions& options)
      : problem_(problem), parameters_(parameters), options_(options), n_(parameters.size()) {
    for (const FreeParameter& p : parameters) value_.push_back(std::clamp(p.value, p.least, p.most));
    jacobian_ = Dense(n_, problem.measured.size());
    error_ = errors(value_);
    fit_.sigma = options.sigma.empty() ? channel_sigma(error_) : options.sigma;
  }

  OutputFit run() {
    double cost = cost_of(error_), lambda = 1e-3;
    for (fit_.rounds = 0; fit_.rounds < options_.most_rounds && !fit_.settled; ++fit_.rounds) {
      differentiate();
      if (fit_.rounds > 0 && options_.sigma.empty()) fit_.sigma = channel_sigma(error_), cost = cost_of(error_);
      normal_equations();
      const double before = cost;
      bool better = false;
      for (int tries = 0; tries < 8 && !better; ++tries) {
        const std::vector<double> next = stepped(lambda);
        if (next.empty()) {
          lambda *= 10;
          continue;
        }
        std::vector<double> error = errors(next);
        const double cost_there = cost_of(error);
        better = cost_there < cost;
        if (better) {
          value_ = next, error_ = std::move(error), cost = cost_there;
          lambda = std::max(lambda * 0.2, 1e-9);
        } else {
          lambda *= 6;
        }
      }
      fit_.settled = !better || before - cost < options_.settled * before;
    }
    fit_.value = value_;
    differentiate();
    if (options_.sigma.empty()) fit_.sigma = channel_sigma(error_);
    fit_.cost = cost_of(error_);
    normal_equations();
    find_intervals();
    return std::move(fit_);
  }

 private:
  std::vector<double> errors(const std::vector<double>& value) const {
    std::vector<double> out(problem_.measured.size());
    problem_.run(value, out);
    for (std::size_t i = 0; i < out.size(); ++i) {
      out[i] = problem_.measured[i] - out[i];
      if (math::is_nan(out[i])) out[i] = 0;  // not measured
    }
    return out;
  }

  std::vector<double> channel_sigma(const std::vector<double>& error) const {
    std::vector<std::vector<double>> size(problem_.channels);
    for (std::size_t i = 0; i < error.size(); ++i)
      if (!math::is_nan(problem_.measured[i])) size[problem_.channel[i]].push_back(math::fabs(error[i]));
    std::vector<double> sigma;
    for (std::vector<double>& s : size) {
      const auto middle = s.begin() + static_cast<std::ptrdiff_t>(s.size() / 2);
      std::nth_element(s.begin(), middle, s.end());
      sigma.push_back(s.empty() ? 1 : std::max(kSigmaOfMedian * *middle, 1e-12));
    }
    return sigma;
  }

  double cost_of(const std::vector<double>& error) const {
    double sum = 0;
    for (std::size_t i = 0; i < error.size(); ++i) {
      const double e = math::fabs(error[i]) / fit_.sigma[problem_.channel[i]];
      sum += e < kHuber ? e * e : kHuber * (2 * e - kHuber);
    }
    return sum;
  }

  /// 1 / sigma^2 of an output, less for errors that are too large.
  double weight(std::size_t i) const {
    const double s = fit_.sigma[problem_.channel[i]], e = math::fabs(error_[i]) / s;
    return (e > kHuber ? kHuber / e : 1) / (s * s);
  }

  void differentiate() {
    std::vector<double> high(problem_.measured.size()), low(high.size()), value = value_;
    for (std::size_t p = 0; p < n_; ++p) {
      const FreeParameter& free = parameters_[p];
      const bool upwards = value_[p] + free.step <= free.most;
      const double up = upwards || options_.both_sides ? std::min(value_[p] + free.step, free.most) : value_[p];
      const double down = !upwards || options_.both_sides ? std::max(value_[p] - free.step, free.least) : value_[p];
      double* const row = jacobian_.row(p);
      if (!(up > down)) {
        std::fill_n(row, high.size(), 0.0);
        continue;
      }
      value[p] = up;
      if (up > value_[p]) problem_.run(value, high);
      value[p] = down;
      if (down < value_[p]) problem_.run(value, low);
      value[p] = value_[p];
      for (std::size_t i = 0; i < high.size(); ++i) {
        const double here = problem_.measured[i] - error_[i];
        row[i] = math::is_nan(here)
                     ? 0
                     : ((up > value_[p] ? high[i] : here) - (down < value_[p] ? low[i] : here)) / (up - down);
      }
    }
  }

  void normal_equations() {
    normal_ = Dense(n_, n_);
    gradient_.assign(n_, 0);
    std::vector<double> weight(error_.size());
    for (std::size_t i = 0; i < weight.size(); ++i) weight[i] = this->weight(i);
    for (std::size_t p = 0; p < n_; ++p) {
      const double* of_p = jacobian_.row(p);
      for (std::size_t i = 0; i < weight.size(); ++i) gradient_[p] += weight[i] * of_p[i] * error_[i];
      for (std::size_t q = 0; q <= p; ++q) {
        const double* of_q = jacobian_.row(q);
        double sum = 0;
        for (std::size_t i = 0; i < weight.size(); ++i) sum += weight[i] * of_p[i] * of_q[i];
        normal_(p, q) = normal_(q, p) = sum * parameters_[p].scale * parameters_[q].scale;
      }
    }
    for (std::size_t p = 0; p < n_; ++p) gradient_[p] *= parameters_[p].scale;
  }

  /// On a bound, and better values lie beyond it.
  bool held(std::size_t p) const {
    return (value_[p] <= parameters_[p].least && gradient_[p] <= 0) ||
           (value_[p] >= parameters_[p].most && gradient_[p] >= 0);
  }

  /// Empty: the equations have no solution.
  std::vector<double> stepped(double lambda) const {
    Dense a = normal_;
    std::vector<double> b = gradient_;
    for (std::size_t p = 0; p < n_; ++p) {
      a(p, p) += lambda * a(p, p) + 1e-9;
      if (!held(p)) continue;
      for (std::size_t q = 0; q < n_; ++q) a(p, q) = a(q, p) = 0;
      a(p, p) = 1, b[p] = 0;
    }
    const auto step = solve_positive(a, b);
    if (!step) return {};
    std::vector<double> next(n_);
    for (std::size_t p = 0; p < n_; ++p)
      next[p] = std::clamp(value_[p] + (*step)[p] * parameters_[p].scale, parameters_[p].least, parameters_[p].most);
    return next;
  }

  void find_intervals() {
    fit_.covariance = Dense(n_, n_);
    for (std::size_t p = 0; p < n_; ++p) fit_.covariance(p, p) = math::kInf;
    fit_.at_bound.assign(n_, false);
    std::vector<std::size_t> free;
    for (std::size_t p = 0; p < n_; ++p) {
      fit_.at_bound[p] = held(p);
      if (!fit_.at_bound[p]) free.push_back(p);
    }
    const std::size_t m = free.size();
    if (m == 0) return;
    Dense normal(m, m);
    for (std::size_t i = 0; i < m; ++i)
      for (std::size_t j = 0; j < m; ++j) normal(i, j) = normal_(free[i], free[j]);
    const SymmetricEigen eigen = symmetric_eigen(normal);

    // Each block's gradient, in scales and along the eigenvectors.
    Dense block(problem_.blocks, m);
    for (std::size_t i = 0; i < error_.size(); ++i) {
      const double e = error_[i] * weight(i);
      if (e == 0) continue;
      for (std::size_t k = 0; k < m; ++k)
        block(problem_.block[i], k) += e * jacobian_(free[k], i) * parameters_[free[k]].scale;
    }
    Dense along(problem_.blocks, m);
    std::size_t used = 0;
    for (std::size_t b = 0; b < problem_.blocks; ++b) {
      bool any = false;
      for (std::size_t v = 0; v < m; ++v)
        for (std::size_t k = 0; k < m; ++k) along(b, v) += block(b, k) * eigen.vectors(k, v);
      for (std::size_t k = 0; k < m; ++k) any = any || block(b, k) != 0;
      used += any ? 1 : 0;
    }
    const double blocks = static_cast<double>(used), freedom = blocks - static_cast<double>(m);
    if (freedom < 1) return;
    const double correct = blocks / freedom;
    // Covariance along two eigenvectors.
    const auto covariance = [&](std::size_t v, std::size_t w) {
      double sum = 0;
      for (std::size_t b = 0; b < problem_.blocks; ++b) sum += along(b, v) * along(b, w);
      return correct * sum / (eigen.values[v] * eigen.values[w]);
    };
    std::vector<bool> shown(m);
    for (std::size_t v = 0; v < m; ++v) {
      shown[v] = eigen.values[v] > 1e-12 * eigen.values[m - 1];
      const double sigma = shown[v] ? math::sqrt(std::max(covariance(v, v), 1 / eigen.values[v])) : math::kInf;
      if (sigma < options_.weak_sigma) continue;
      OutputFit::Weak weak{std::vector<double>(n_), sigma};
      for (std::size_t k = 0; k < m; ++k) weak.parts[free[k]] = eigen.vectors(k, v);
      fit_.weak.push_back(std::move(weak));
    }
    fit_.quantile = student_95(freedom);
    Dense between(m, m);
    for (std::size_t v = 0; v < m; ++v)
      for (std::size_t w = 0; w < m; ++w) between(v, w) = shown[v] && shown[w] ? covariance(v, w) : 0;
    for (std::size_t k = 0; k < m; ++k)
      for (std::size_t l = 0; l < m; ++l) {
        double sum = 0;
        for (std::size_t v = 0; v < m; ++v)
          for (std::size_t w = 0; w < m; ++w) sum += eigen.vectors(k, v) * eigen.vectors(l, w) * between(v, w);
        fit_.covariance(free[k], free[l]) = sum * parameters_[free[k]].scale * parameters_[free[l]].scale;
      }
    for (std::size_t k = 0; k < m; ++k)
      for (std::size_t v = 0; v < m; ++v)
        if (!shown[v] && math::fabs(eigen.vectors(k, v)) > 0.1) fit_.covariance(free[k], free[k]) = math::kInf;
  }

  const OutputProblem& problem_;
  std::span<const FreeParameter> parameters_;
  const OutputFitOptions& options_;
  std::size_t n_;
  std::vector<double> value_, error_, gradient_;
  Dense jacobian_, normal_;  // a row for each parameter
  OutputFit fit_;
};

}  // namespace

OutputFit fit_outputs(const OutputProblem& problem, std::span<const FreeParameter> parameters,
                      const OutputFitOptions& options) {
  return Fitter(problem, parameters, options).run();
}

}  // namespace sinew::identify
