#include "hal/clock_filter.hpp"

#include <algorithm>
#include <limits>
#include <span>

namespace sinew::hal {
namespace {

constexpr double kReadingNs = 1;  // clocks are read in whole nanoseconds

double ns_between(Time from, Time to) { return static_cast<double>((to - from).count()); }

// By conversion alone, so that every machine has the same bits.
std::int64_t rounded(double v) { return static_cast<std::int64_t>(v < 0 ? v - 0.5 : v + 0.5); }
std::int64_t rounded_up(double v) {
  const auto whole = static_cast<std::int64_t>(v);
  return static_cast<double>(whole) < v ? whole + 1 : whole;
}

}  // namespace

bool ClockFilter::add(Time asked, Time received, Time answered, Time arrived) {
  const bool possible = arrived >= asked && answered >= received && arrived - asked >= answered - received;
  if (!possible || (any() && arrived < newest_)) {
    ++rejected_;
    return false;
  }
  if (!any()) base_ = asked - received;
  if (count_ == kWindow) forget(1);
  const auto relative = [&](Duration d) { return static_cast<double>((d - base_).count()); };
  pairs_[static_cast<std::size_t>(count_++)] = {{asked, relative(asked - received) - kReadingNs},
                                                {arrived, relative(arrived - answered) + kReadingNs}};
  newest_ = arrived;
  if (fit()) return true;
  ++restarts_;
  while (!fit()) forget((count_ + 1) / 2);
  return true;
}

void ClockFilter::forget(std::uint64_t oldest) {
  const std::span<Pair> pairs(pairs_.data(), static_cast<std::size_t>(count_));
  std::copy(pairs.begin() + static_cast<std::ptrdiff_t>(oldest), pairs.end(), pairs.begin());
  count_ -= oldest;
}

/// False: no line passes between the limits.
bool ClockFilter::fit() {
  const std::span<const Pair> pairs(pairs_.data(), static_cast<std::size_t>(count_));
  slowest_ = -kMaxDrift, fastest_ = kMaxDrift;
  for (const Pair& a : pairs) {
    for (const Pair& b : pairs) {
      if (b.high.at > a.low.at)
        fastest_ = std::min(fastest_, (b.high.value_ns - a.low.value_ns) / ns_between(a.low.at, b.high.at));
      if (b.high.at < a.low.at)
        slowest_ = std::max(slowest_, (a.low.value_ns - b.high.value_ns) / ns_between(b.high.at, a.low.at));
    }
  }
  low_ns_ = -std::numeric_limits<double>::infinity(), high_ns_ = std::numeric_limits<double>::infinity();
  for (const Pair& p : pairs) {
    low_ns_ = std::max(low_ns_, p.low.value_ns + slowest_ * ns_between(p.low.at, newest_));
    high_ns_ = std::min(high_ns_, p.high.value_ns + fastest_ * ns_between(p.high.at, newest_));
  }
  return slowest_ <= fastest_ && low_ns_ <= high_ns_;
}

ClockFilter::Estimate ClockFilter::at(Time ours) const {
  const double ahead = std::max(0.0, ns_between(newest_, ours));
  const double low = low_ns_ + slowest_ * ahead, high = high_ns_ + fastest_ * ahead;
  Estimate e;
  e.offset = base_ + Duration(rounded((low + high) / 2));
  e.bound = Duration(rounded_up((high - low) / 2));
  e.drift = (slowest_ + fastest_) / 2;
  return e;
}

}  // namespace sinew::hal
