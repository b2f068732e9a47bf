#pragma once
// What many runs say together: how sure a share is, whether two sweeps differ, and how a measure is spread.
#include <cstdint>
#include <map>
#include <vector>

namespace sinew::sweep {

struct Interval {
  double low = 0, high = 1;
  double width() const { return high - low; }
};

/// Where the true share lies with 95 % confidence when `good` of `all` independent runs were good; 0 to 1 for no runs.
/// Source:  E. B. Wilson, "Probable inference, the law of succession, and statistical inference", JASA 22 (1927).
Interval wilson_95(std::uint64_t good, std::uint64_t all);

/// How probable it is that pairs of runs differ at least as unevenly as here although neither side is better: `better`
/// and `worse` count the pairs that differ. Two-sided, exact.
/// Source:  Q. McNemar, Psychometrika 12 (1947); exact: the binomial distribution of one half.
double mcnemar_p(std::uint64_t better, std::uint64_t worse);

/// Quantiles of any number of values in bounded memory, whatever the order of the values. Exact for few values; for
/// more than kExact the error is at most 0.3 % of the value, and values below 1e-12 count as 0.
class Quantiles {
 public:
  static constexpr std::size_t kExact = 1024;
  void add(double value);  // finite
  std::uint64_t count() const { return count_; }
  double least() const { return least_; }
  double most() const { return most_; }
  /// The value below which `share` (0..1) of all lie; 0 without values.
  double at(double share) const;

 private:
  void put(double value) { ++buckets_[bucket_of(value)]; }
  static int bucket_of(double value);
  static double middle_of(int bucket);

  std::vector<double> few_;               // in use until there are more
  std::map<int, std::uint64_t> buckets_;  // by sign and logarithm
  std::uint64_t count_ = 0;
  double least_ = 0, most_ = 0;
};

}  // namespace sinew::sweep
