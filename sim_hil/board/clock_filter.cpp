#include "sim_hil/board/clock_filter.hpp"

#include <algorithm>
#include <cmath>

namespace sinew::sim_hil {
namespace {

constexpr double kReadingNs = 1;  // clocks are read in whole nanoseconds

}  // namespace

bool ClockFilter::add(Time asked, Time received, Time answered, Time arrived) {
  const bool possible = arrived >= asked && answered >= received && arrived - asked >= answered - received;
  if (!possible || (any() && arrived < newest_)) {
    ++rejected_;
    return false;
  }
  if (pairs_.empty()) base_ = asked - received;
  if (pairs_.size() == options_.window) pairs_.erase(pairs_.begin());
  const auto relative = [&](Duration d) { return static_cast<double>((d - base_).count()); };
  pairs_.push_back(
      {{asked, relative(asked - received) - kReadingNs}, {arrived, relative(arrived - answered) + kReadingNs}});
  newest_ = arrived;
  if (fit()) return true;
  ++restarts_;
  while (!fit()) pairs_.erase(pairs_.begin(), pairs_.begin() + static_cast<std::ptrdiff_t>((pairs_.size() + 1) / 2));
  return true;
}

/// False: no line passes between the limits.
bool ClockFilter::fit() {
  slowest_ = -options_.max_drift, fastest_ = options_.max_drift;
  for (const Pair& a : pairs_) {
    for (const Pair& b : pairs_) {
      if (b.high.at > a.low.at)
        fastest_ = std::min(fastest_, (b.high.value_ns - a.low.value_ns) / since(a.low.at, b.high.at));
      if (b.high.at < a.low.at)
        slowest_ = std::max(slowest_, (a.low.value_ns - b.high.value_ns) / since(b.high.at, a.low.at));
    }
  }
  low_ns_ = -HUGE_VAL, high_ns_ = HUGE_VAL;
  for (const Pair& p : pairs_) {
    low_ns_ = std::max(low_ns_, p.low.value_ns + slowest_ * since(p.low.at, newest_));
    high_ns_ = std::min(high_ns_, p.high.value_ns + fastest_ * since(p.high.at, newest_));
  }
  return slowest_ <= fastest_ && low_ns_ <= high_ns_;
}

ClockFilter::Estimate ClockFilter::at(Time ours) const {
  const double ahead = std::max(0.0, since(newest_, ours));
  const double low = low_ns_ + slowest_ * ahead, high = high_ns_ + fastest_ * ahead;
  Estimate e;
  e.offset = base_ + Duration(std::llround((low + high) / 2));
  e.bound = Duration(static_cast<std::int64_t>(std::ceil((high - low) / 2)));
  e.drift = (slowest_ + fastest_) / 2;
  return e;
}

}  // namespace sinew::sim_hil
