#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "hal/clock.hpp"

namespace sinew::sim_hil {

using hal::Duration;
using hal::Time;

/// How far another machine's clock stands from ours, from exchanges of four time stamps. Pure.
///
/// An answer cannot arrive before it was sent, whatever the way there and back take. So the offset (ours minus theirs)
/// is at least asked - received when we ask, and at most arrived - answered when the answer arrives. Between two clocks
/// of constant rates the offset is a straight line over time, which has to pass above all the former and below all the
/// latter; what lines are left gives offset, drift and their bounds. Slow and lopsided exchanges thus say little and do
/// no harm, the fastest ones of either direction decide.
/// Thread:  owner.   RT: no; add() compares all pairs of the window.
class ClockFilter {
 public:
  struct Options {
    std::size_t window = 64;    // exchanges that are looked at; in their time the drift has to stay what it is
    double max_drift = 500e-6;  // no two clocks drift apart faster, as a ratio (what NTP may slew, and any crystal)
  };
  ClockFilter() : ClockFilter(Options{}) {}
  explicit ClockFilter(const Options& options) : options_(options) {}

  /// One exchange: our clock as we asked, theirs as they received and as they answered, ours as the answer arrived.
  /// Not earlier than the last. False, and counted, when these cannot be times of one exchange.
  bool add(Time asked, Time received, Time answered, Time arrived);

  struct Estimate {
    Duration offset{0};  // ours minus theirs
    Duration bound{0};   // the true offset lies within offset +- bound
    double drift = 0;    // growth of the offset per time of ours
  };
  /// At a time of ours at or after the last exchange; `any()` must be true.
  Estimate at(Time ours) const;
  bool any() const { return !pairs_.empty(); }

  /// Exchanges that could not be.
  std::uint32_t rejected() const { return rejected_; }
  /// Times that no line was left: a clock jumped or changed its pace. What came before was forgotten.
  std::uint32_t restarts() const { return restarts_; }

 private:
  struct Limit {
    Time at;          // ours
    double value_ns;  // relative to base_
  };
  struct Pair {
    Limit low, high;
  };
  bool fit();
  double since(Time from, Time to) const { return static_cast<double>((to - from).count()); }

  Options options_;
  std::vector<Pair> pairs_;                                      // oldest first
  Duration base_{0};                                             // so that doubles hold nanoseconds exactly
  double slowest_ = 0, fastest_ = 0, low_ns_ = 0, high_ns_ = 0;  // of the lines left; values at `newest_`
  Time newest_{};
  std::uint32_t rejected_ = 0, restarts_ = 0;
};

}  // namespace sinew::sim_hil
