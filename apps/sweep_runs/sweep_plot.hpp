#pragma once
// One measure of many runs, drawn: how often it has which values, or how it depends on the seed or on a setting.
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "apps/sweep/case_result.hpp"
#include "apps/sweep/statistics.hpp"

namespace sinew::app {

/// Thread:  owner.
class SweepPlot {
 public:
  /// `over`: "seed" or the key of a setting; empty: a histogram.
  SweepPlot(std::string measure, std::string over) : measure_(std::move(measure)), over_(std::move(over)) {}

  /// A run. False, with `why`: what it is drawn over is no number there.
  bool add(const sweep::CaseResult& result, std::string& why);
  /// After all runs: a histogram has to see them twice. True once.
  bool needs_another_look();
  /// Empty when the file is written; else why not.
  std::string write(const std::string& path) const;

 private:
  static constexpr std::size_t kBins = 40, kMostValues = 10'000;
  void count(double value);

  const std::string measure_, over_;
  sweep::Limits limits_;
  bool counting_ = false;
  double low_ = 0, high_ = 0;
  sweep::Quantiles all_;
  std::vector<std::uint64_t> bins_;
  std::map<double, sweep::Quantiles> by_value_;
  std::vector<std::pair<double, double>> by_seed_;
};

}  // namespace sinew::app
