#pragma once
#include <cstdint>
#include <functional>
#include <utility>

#include "hal/board.hpp"
#include "rt/exec/discrete_executor.hpp"

namespace sinew::app {

/// Grants of a board in virtual time, passed on. Between two of them, where the graph stands still, it is asked now and
/// then whether the run is over; if so the executor is stopped.
/// Thread:  the executor's.
class WatchedGrants final : public hal::GrantSource {
 public:
  /// `over` is told how far the run has come; `stop` is asked at every grant.
  WatchedGrants(
      hal::GrantSource& board, std::function<bool(hal::Time done)> over, bool (*stop)() = [] { return false; })
      : board_(board), over_(std::move(over)), stop_(stop) {}
  hal::Result<hal::Time> next_grant(hal::Time done) override {
    if (stop_() || (++grants_ % kLookEvery == 0 && over_(done))) executor->request_stop();
    return board_.next_grant(done);
  }
  rt::DiscreteExecutor* executor = nullptr;  // made from this; set it before it runs

 private:
  static constexpr std::uint64_t kLookEvery = 64;
  hal::GrantSource& board_;
  std::function<bool(hal::Time)> over_;
  bool (*const stop_)();
  std::uint64_t grants_ = 0;
};

}  // namespace sinew::app
