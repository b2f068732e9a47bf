#pragma once
// Parameters of a simulated model whose outputs come closest to what was measured.
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "identify/dense.hpp"

namespace sinew::identify {

struct FreeParameter {
  double value = 0;
  double least = 0, most = 0;
  double step = 0;   // with which derivatives are taken
  double scale = 1;  // what would be a large change of it
};

struct OutputProblem {
  /// Outputs for these values; as many as `measured`.
  std::function<void(std::span<const double> values, std::span<double> outputs)> run;
  std::vector<double> measured;        // NaN: does not count
  std::vector<std::uint32_t> channel;  // of each output: those of one channel have errors of one size
  std::vector<std::uint32_t> block;    // errors of different blocks are independent
  std::size_t channels = 0, blocks = 0;
};

struct OutputFit {
  std::vector<double> value;
  std::vector<double> sigma;  // of each channel's errors, by their median
  double cost = 0;            // Huber's sum of the errors, each in the channel's sigmas
  int rounds = 0;
  bool settled = false;
  /// Of the values; infinite on the diagonal for what the outputs do not show.
  Dense covariance;
  double quantile = 0;  // so many standard errors to each side are 95 %
  std::vector<bool> at_bound;
  /// Changes of the parameters, in their scales, of unit length, that the outputs do not show; `sigma`: how far along
  /// it the values are uncertain.
  struct Weak {
    std::vector<double> parts;
    double sigma = 0;
  };
  std::vector<Weak> weak;
};

struct OutputFitOptions {
  int most_rounds = 25;
  double settled = 1e-4;        // the cost falls by a smaller share: done
  double weak_sigma = 0.5;      // in scales: a direction that is less certain is named
  bool both_sides = true;       // derivatives; false: half the time, less exact
  std::vector<double> sigma{};  // of the channels at first; empty: by the errors at the start
};

/// Levenberg-Marquardt within bounds; channels are weighted by their own errors, and errors beyond 2.5 sigmas count
/// linearly. Intervals allow for errors that depend on each other within a block.
/// Source:  J. More, The Levenberg-Marquardt algorithm (1978); L. Ljung, System Identification (1999), 7 and 9;
///          P. Huber, Robust Statistics (1981); K.-Y. Liang, S. Zeger, Longitudinal data analysis using generalized
///          linear models (1986) for the blocks.
/// Thread:  owner.   RT: no.
OutputFit fit_outputs(const OutputProblem& problem, std::span<const FreeParameter> parameters,
                      const OutputFitOptions& options = {});

}  // namespace sinew::identify
