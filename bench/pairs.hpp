#pragma once
// Two programs alternated in one process: ratios that hold on a noisy machine, where absolute times do not.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <vector>

namespace sinew::bench {

/// Median of `v`; sorts it.
inline double median(std::vector<double>& v) {
  std::sort(v.begin(), v.end());
  return v.empty() ? 0 : v[v.size() / 2];
}

struct Ratio {
  double ratio = 0, low = 0, high = 0;  // median over the pairs and its 95 % interval (sign test)
  double ours_us = 0, floor_us = 0;     // medians
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
    return median(us);
  };
  batch(ours), batch(floor);  // warm
  std::vector<double> ratios, a, b;
  for (int i = 0; i < pairs; ++i) {
    double x, y;
    if (i % 2 == 0)
      x = batch(ours), y = batch(floor);
    else
      y = batch(floor), x = batch(ours);
    a.push_back(x), b.push_back(y), ratios.push_back(x / y);
  }
  Ratio r{median(ratios), 0, 0, median(a), median(b)};
  // Ranks of the interval: n/2 -+ 0.98 sqrt(n), the binomial's 95 %.
  const int n = static_cast<int>(ratios.size());
  int k = 0;
  while ((k + 1) * (k + 1) <= 0.9604 * n) ++k;
  r.low = ratios[std::size_t(std::max(0, n / 2 - k))], r.high = ratios[std::size_t(std::min(n - 1, n / 2 + k))];
  return r;
}

/// One line for people and for bench/run: name, ratio, interval, goal (0: none).
inline bool report(const char* name, const Ratio& r, double goal, const char* unit = "us") {
  const bool good = goal == 0 || r.low <= goal;  // a clear miss fails, not a noisy one
  std::printf("%-34s %.3f x its floor [%.3f..%.3f]  goal %.2f  %-4s (%.1f %s, floor %.1f %s)\n", name, r.ratio, r.low,
              r.high, goal,
              goal == 0         ? "-"
              : r.ratio <= goal ? "ok"
              : good            ? "near"
                                : "MISS",
              r.ours_us, unit, r.floor_us, unit);
  std::fflush(stdout);
  return good;
}

template <class T>
void keep(const T& v) {
  asm volatile("" : : "r,m"(v) : "memory");
}

}  // namespace sinew::bench
