#pragma once
#include <cstddef>
#include <optional>

#include "msg/flight.hpp"

namespace sinew::app {

/// Distance between where a robot believes it is and where it is. The estimator's world begins where the filter
/// started, the simulator's world does not: both are compared from the first pair of states with a valid estimate on.
/// Thread:  owner.
class EstimateError {
 public:
  struct Result {
    double worst_m = 0, last_m = 0;  // horizontal
  };
  void add(const msg::NavState& estimate, const msg::NavState& truth);
  /// Nothing before the first pair.
  std::optional<Result> result() const { return pairs_ > 0 ? std::optional(result_) : std::nullopt; }

 private:
  msg::NavState estimate_, truth_;  // of the first pair
  double cos_ = 1, sin_ = 0;        // turns the truth's world into the estimate's
  std::size_t pairs_ = 0;
  Result result_;
};

}  // namespace sinew::app
