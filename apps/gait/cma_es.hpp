#pragma once
// Search for the least of a noisy function of some numbers, without its derivatives.
#include <cstdint>
#include <span>
#include <vector>

#include "math/random.hpp"

namespace sinew::gait {

/// Covariance matrix adaptation: each generation samples a normal distribution, and moves and reshapes it to where the
/// best of the samples were. Numbers are scaled to 0..1 by the caller; samples outside are put on the border.
/// The same seed and costs give the same samples on every machine.
/// Source:  N. Hansen, The CMA evolution strategy: a tutorial (2016), arXiv:1604.00772, figure 6; weights of the best
///          half only.
/// Thread:  owner.
class CmaEs {
 public:
  /// `samples`: of a generation, at least 4; 0: 4 + 3 log(n).
  CmaEs(std::span<const double> start, double sigma, std::uint64_t seed, std::size_t samples = 0);

  /// The samples of the next generation.
  const std::vector<std::vector<double>>& ask();
  /// Their costs in the same order; one that is not finite is worst.
  void tell(std::span<const double> costs);

  std::span<const double> mean() const { return mean_; }
  double sigma() const { return sigma_; }
  std::size_t generation() const { return generation_; }

 private:
  void decompose();

  std::size_t n_, lambda_;
  std::uint64_t seed_;
  std::size_t generation_ = 0;
  std::vector<double> weights_;
  double mu_eff_ = 0, c_sigma_ = 0, d_sigma_ = 0, c_c_ = 0, c_1_ = 0, c_mu_ = 0, chi_ = 0;
  std::vector<double> mean_, path_sigma_, path_c_;
  double sigma_;
  std::vector<double> c_, b_, d_;  // covariance, its eigenvectors (columns) and roots of eigenvalues; n x n row-major
  std::vector<std::vector<double>> samples_, steps_;
};

}  // namespace sinew::gait
