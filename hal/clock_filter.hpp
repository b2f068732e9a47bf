#pragma once
#include <array>
#include <cstdint>

#include "hal/clock.hpp"

namespace sinew::hal {

/// How far another machine's clock stands from ours, from exchanges of four time stamps. Pure, and plain memory: it can
/// be the state of a module.
///
/// An answer cannot arrive before it was sent, however long the way there and back takes. So the offset (ours minus
/// theirs) is at least asked - received when we ask, and at most arrived - answered when the answer arrives. Between
/// two clocks of constant rates the offset is a straight line over time. This line has to pass above all lower limits
/// and below all upper limits; the lines that do give offset, drift and their bounds. Slow and lopsided exchanges thus
/// say little and do no harm; the fastest exchanges of either direction decide.
/// Thread:  owner.   RT: yes; add() compares all pairs of the window.
class ClockFilter {
 public:
  static constexpr std::uint32_t kWindow = 64;  // exchanges that are looked at; the drift must not change during them
  static constexpr double kMaxDrift = 500e-6;   // no two clocks drift apart faster (what NTP may slew, and any crystal)

  /// One exchange: our clock as we asked, theirs as they received and as they answered, ours as the answer arrived. Not
  /// earlier than the last exchange. False, and counted: these cannot be times of one exchange.
  bool add(Time asked, Time received, Time answered, Time arrived);

  struct Estimate {
    Duration offset{0};  // ours minus theirs
    Duration bound{0};   // the true offset lies within offset +- bound
    double drift = 0;    // growth of the offset per time of ours
  };
  /// At a time of ours at or after the last exchange; `any()` must be true.
  Estimate at(Time ours) const;
  bool any() const { return count_ != 0; }

  /// Exchanges whose times could not be of one exchange.
  std::uint32_t rejected() const { return rejected_; }
  /// How often no line was left: a clock jumped or changed its pace. The exchanges before were forgotten then.
  std::uint32_t restarts() const { return restarts_; }

 private:
  struct Limit {
    Time at{};            // ours
    double value_ns = 0;  // relative to base_
  };
  struct Pair {
    Limit low{}, high{};
  };
  void forget(std::uint64_t oldest);
  bool fit();

  std::array<Pair, kWindow> pairs_{};                            // the first count_; oldest first
  Duration base_{0};                                             // so that doubles hold nanoseconds exactly
  double slowest_ = 0, fastest_ = 0, low_ns_ = 0, high_ns_ = 0;  // of the lines left; values at `newest_`
  Time newest_{};
  std::uint64_t count_ = 0;  // as wide as what precedes it: the state of a module has no padding
  std::uint32_t rejected_ = 0, restarts_ = 0;
};

}  // namespace sinew::hal
