#include "apps/gait/cma_es.hpp"

#include <algorithm>
#include <numeric>

#include "math/elementary.hpp"

namespace sinew::gait {

CmaEs::CmaEs(std::span<const double> start, double sigma, std::uint64_t seed, std::size_t samples)
    : n_(start.size()), seed_(seed), mean_(start.begin(), start.end()), sigma_(sigma) {
  const auto n = static_cast<double>(n_);
  lambda_ = samples >= 4 ? samples : 4 + static_cast<std::size_t>(3 * math::log(n));
  const std::size_t mu = lambda_ / 2;
  for (std::size_t i = 0; i < mu; ++i)
    weights_.push_back(math::log(0.5 * static_cast<double>(lambda_ + 1)) - math::log(static_cast<double>(i + 1)));
  const double total = std::accumulate(weights_.begin(), weights_.end(), 0.0);
  double squares = 0;
  for (double& w : weights_) w /= total, squares += w * w;
  mu_eff_ = 1 / squares;
  c_sigma_ = (mu_eff_ + 2) / (n + mu_eff_ + 5);
  d_sigma_ = 1 + 2 * std::max(0.0, math::sqrt((mu_eff_ - 1) / (n + 1)) - 1) + c_sigma_;
  c_c_ = (4 + mu_eff_ / n) / (n + 4 + 2 * mu_eff_ / n);
  c_1_ = 2 / ((n + 1.3) * (n + 1.3) + mu_eff_);
  c_mu_ = std::min(1 - c_1_, 2 * (mu_eff_ - 2 + 1 / mu_eff_) / ((n + 2) * (n + 2) + mu_eff_));
  chi_ = math::sqrt(n) * (1 - 1 / (4 * n) + 1 / (21 * n * n));
  path_sigma_.assign(n_, 0);
  path_c_.assign(n_, 0);
  c_.assign(n_ * n_, 0);
  for (std::size_t i = 0; i < n_; ++i) c_[i * n_ + i] = 1;
  decompose();
}

const std::vector<std::vector<double>>& CmaEs::ask() {
  math::Random random(seed_, 0xc3a, generation_);
  samples_.assign(lambda_, std::vector<double>(n_));
  steps_ = samples_;
  std::vector<double> z(n_);
  for (std::size_t k = 0; k < lambda_; ++k) {
    for (double& value : z) value = random.normal();
    for (std::size_t i = 0; i < n_; ++i) {
      double y = 0;
      for (std::size_t j = 0; j < n_; ++j) y += b_[i * n_ + j] * d_[j] * z[j];
      samples_[k][i] = std::clamp(mean_[i] + sigma_ * y, 0.0, 1.0);
      steps_[k][i] = (samples_[k][i] - mean_[i]) / sigma_;
    }
  }
  return samples_;
}

void CmaEs::tell(std::span<const double> costs) {
  std::vector<std::size_t> order(lambda_);
  std::iota(order.begin(), order.end(), 0u);
  const auto cost = [&](std::size_t k) { return math::is_finite(costs[k]) ? costs[k] : math::kInf; };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return cost(a) < cost(b); });

  std::vector<double> y(n_, 0);
  for (std::size_t i = 0; i < weights_.size(); ++i)
    for (std::size_t j = 0; j < n_; ++j) y[j] += weights_[i] * steps_[order[i]][j];
  for (std::size_t j = 0; j < n_; ++j) mean_[j] += sigma_ * y[j];

  // The path of the step size, in axes in which the distribution is round.
  std::vector<double> round(n_, 0), whitened(n_, 0);
  for (std::size_t j = 0; j < n_; ++j) {
    for (std::size_t i = 0; i < n_; ++i) round[j] += b_[i * n_ + j] * y[i];
    round[j] /= d_[j];
  }
  for (std::size_t i = 0; i < n_; ++i)
    for (std::size_t j = 0; j < n_; ++j) whitened[i] += b_[i * n_ + j] * round[j];
  double length = 0;
  for (std::size_t i = 0; i < n_; ++i) {
    path_sigma_[i] = (1 - c_sigma_) * path_sigma_[i] + math::sqrt(c_sigma_ * (2 - c_sigma_) * mu_eff_) * whitened[i];
    length += path_sigma_[i] * path_sigma_[i];
  }
  length = math::sqrt(length);
  const double passed = 1 - math::exp(2 * static_cast<double>(generation_ + 1) * math::log(1 - c_sigma_));
  const bool steady = length / math::sqrt(passed) < (1.4 + 2 / (static_cast<double>(n_) + 1)) * chi_;
  for (std::size_t i = 0; i < n_; ++i)
    path_c_[i] = (1 - c_c_) * path_c_[i] + (steady ? math::sqrt(c_c_ * (2 - c_c_) * mu_eff_) * y[i] : 0);

  const double kept = 1 - c_1_ - c_mu_ + (steady ? 0 : c_1_ * c_c_ * (2 - c_c_));
  for (std::size_t i = 0; i < n_; ++i)
    for (std::size_t j = 0; j < n_; ++j) {
      double rank_mu = 0;
      for (std::size_t k = 0; k < weights_.size(); ++k)
        rank_mu += weights_[k] * steps_[order[k]][i] * steps_[order[k]][j];
      c_[i * n_ + j] = kept * c_[i * n_ + j] + c_1_ * path_c_[i] * path_c_[j] + c_mu_ * rank_mu;
    }
  sigma_ *= math::exp(std::min(1.0, c_sigma_ / d_sigma_ * (length / chi_ - 1)));
  ++generation_;
  decompose();
}

/// Eigenvalues by Jacobi's rotations, in a fixed order.
void CmaEs::decompose() {
  std::vector<double> a = c_;
  b_.assign(n_ * n_, 0);
  for (std::size_t i = 0; i < n_; ++i) b_[i * n_ + i] = 1;
  for (int sweep = 0; sweep < 30; ++sweep) {
    double off = 0, on = 0;
    for (std::size_t i = 0; i < n_; ++i)
      for (std::size_t j = 0; j < n_; ++j) (i == j ? on : off) += a[i * n_ + j] * a[i * n_ + j];
    if (off <= 1e-24 * on) break;
    for (std::size_t p = 0; p + 1 < n_; ++p)
      for (std::size_t q = p + 1; q < n_; ++q) {
        const double apq = a[p * n_ + q];
        if (apq == 0) continue;
        const double theta = (a[q * n_ + q] - a[p * n_ + p]) / (2 * apq);
        const double t = (theta < 0 ? -1 : 1) / (math::fabs(theta) + math::sqrt(theta * theta + 1));
        const double c = 1 / math::sqrt(t * t + 1), s = t * c;
        for (std::size_t k = 0; k < n_; ++k) {
          const double kp = a[k * n_ + p], kq = a[k * n_ + q];
          a[k * n_ + p] = c * kp - s * kq;
          a[k * n_ + q] = s * kp + c * kq;
        }
        for (std::size_t k = 0; k < n_; ++k) {
          const double pk = a[p * n_ + k], qk = a[q * n_ + k];
          a[p * n_ + k] = c * pk - s * qk;
          a[q * n_ + k] = s * pk + c * qk;
        }
        for (std::size_t k = 0; k < n_; ++k) {
          const double kp = b_[k * n_ + p], kq = b_[k * n_ + q];
          b_[k * n_ + p] = c * kp - s * kq;
          b_[k * n_ + q] = s * kp + c * kq;
        }
      }
  }
  d_.assign(n_, 0);
  for (std::size_t i = 0; i < n_; ++i) d_[i] = math::sqrt(std::max(a[i * n_ + i], 1e-20));
}

}  // namespace sinew::gait
