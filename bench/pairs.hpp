#pragma once
// Two programs alternated in one process: ratios that hold on a noisy machine, where absolute times do not.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <vector>

namespace sinew::bench {

/// The value below which the share q of `v` lies; sorts it.
inline double quantile(std::vector<double>& v, double q) {
  std::sort(v.begin(), v.end());
  return v.empty() ? 0 : v[std::min(v.size() - 1, static_cast<std::size_t>(q * static_cast<double>(v.size())))];
}
inline double median(std::vector<double>& v) { return quantile(v, 0.5); }

struct Ratio {
  double ratio = 0, low = 0, high = 0;       // median over the pairs and its 95 % interval (sign test)
  double ours_us = 0, floor_us = 0;          // medians
  double ours_p99_us = 0, floor_p99_us = 0;  // of all single measurements; 0: there are none
  /// The same in another unit.
  Ratio times(double factor) const {
    return {ratio, low, high, ours_us * factor, floor_us * factor, ours_p99_us * factor, floor_p99_us * factor};
  }
};

/// Pairs of batches of single measurements, one ratio of their medians a pair.
class Pairs {
 public:
  void add(std::vector<double> ours, std::vector<double> floor) {
    all_ours_.insert(all_ours_.end(), ours.begin(), ours.end());
    all_floor_.insert(all_floor_.end(), floor.begin(), floor.end());
    ours_.push_back(median(ours)), floor_.push_back(median(floor));
    ratios_.push_back(ours_.back() / floor_.back());
  }
  Ratio ratio() {
    Ratio r{median(ratios_),           0, 0, median(ours_), median(floor_), quantile(all_ours_, 0.99),
            quantile(all_floor_, 0.99)};
    // Ranks of the interval: n/2 -+ 0.98 sqrt(n), the binomial's 95 %.
    const int n = static_cast<int>(ratios_.size());
    int k = 0;
    while ((k + 1) * (k + 1) <= 0.9604 * n) ++k;
    r.low = ratios_[std::size_t(std::max(0, n / 2 - k))], r.high = ratios_[std::size_t(std::min(n - 1, n / 2 + k))];
    return r;
  }

 private:
  std::vector<double> all_ours_, all_floor_, ours_, floor_, ratios_;
};

/// Times batches of `reps` calls of either, in the order AB BA AB ...; one ratio per pair of batches.
template <class Ours, class Floor>
Ratio alternate(int pairs, int reps, const Ours& ours, const Floor& floor) {
  using Clock = std::chrono::steady_clock;
  const auto batch = [&](const auto& call) {
    std::vector<double> us;
    for (int i = 0; i < reps; ++i) {
      const auto start = Clock::now();
      call();
      us.push_back(std::chrono::duration<double, std::micro>(Clock::now() - start).count());
    }
    return us;
  };
  batch(ours), batch(floor);  // warm-up
  Pairs all;
  for (int i = 0; i < pairs; ++i) {
    std::vector<double> x, y;
    if (i % 2 == 0)
      x = batch(ours), y = batch(floor);
    else
      y = batch(floor), x = batch(ours);
    all.add(std::move(x), std::move(y));
  }
  return all.ratio();
}

/// One line for people and for bench/run: name, ratio, interval, goal (0: none).
inline bool report(const char* name, const Ratio& r, double goal, const char* unit = "us") {
  const bool good = goal == 0 || r.low <= goal;  // a clear miss fails, not a noisy one
  std::printf("%-34s %.3f x its floor [%.3f..%.3f]  goal %.2f  %-4s (%.1f %s, floor %.1f %s; p99 %.1f, floor %.1f)\n",
              name, r.ratio, r.low, r.high, goal,
              goal == 0         ? "-"
              : r.ratio <= goal ? "ok"
              : good            ? "near"
                                : "MISS",
              r.ours_us, unit, r.floor_us, unit, r.ours_p99_us, r.floor_p99_us);
  std::fflush(stdout);
  return good;
}

/// One line about a figure with an absolute goal (0: none).
inline bool report_figure(const char* name, double value, double goal, const char* unit) {
  const bool good = goal == 0 || value <= goal;
  std::printf("%-34s %.3f %s  goal %.2f  %s\n", name, value, unit, goal, goal == 0 ? "-" : good ? "ok" : "MISS");
  std::fflush(stdout);
  return good;
}

template <class T>
void keep(const T& v) {
  asm volatile("" : : "r,m"(v) : "memory");
}

}  // namespace sinew::bench
