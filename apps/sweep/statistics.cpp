#include "apps/sweep/statistics.hpp"

#include <algorithm>
#include <cmath>

namespace sinew::sweep {
namespace {

constexpr double kZ95 = 1.959963984540054;  // 97.5 % of the normal distribution lies below it
constexpr double kFactor = 1.005;           // between two buckets
constexpr double kSmallest = 1e-12, kLargest = 1e12;

}  // namespace

Interval wilson_95(std::uint64_t good, std::uint64_t all) {
  if (all == 0) return {};
  const double n = static_cast<double>(all), p = static_cast<double>(good) / n, z2 = kZ95 * kZ95;
  const double middle = (p + z2 / (2 * n)) / (1 + z2 / n);
  const double half = kZ95 / (1 + z2 / n) * std::sqrt(p * (1 - p) / n + z2 / (4 * n * n));
  // Rounding must not say that a share is possible, or impossible, against the counts.
  return {good == 0 ? 0 : std::max(0.0, middle - half), good == all ? 1 : std::min(1.0, middle + half)};
}

double mcnemar_p(std::uint64_t better, std::uint64_t worse) {
  const std::uint64_t n = better + worse, fewer = std::min(better, worse);
  if (better == worse) return 1;
  const double all = static_cast<double>(n);
  double sum = 0;
  for (std::uint64_t k = 0; k <= fewer; ++k) {
    const double part = static_cast<double>(k);
    sum += std::exp(std::lgamma(all + 1) - std::lgamma(part + 1) - std::lgamma(all - part + 1) - all * std::log(2.0));
  }
  return std::min(1.0, 2 * sum);
}

int Quantiles::bucket_of(double value) {
  const double size = std::abs(value);
  if (size < kSmallest) return 0;
  const int steps = 1 + static_cast<int>(std::log(std::min(size, kLargest) / kSmallest) / std::log(kFactor));
  return value < 0 ? -steps : steps;
}

double Quantiles::middle_of(int bucket) {
  if (bucket == 0) return 0;
  const double size = kSmallest * std::pow(kFactor, std::abs(bucket) - 0.5);
  return bucket < 0 ? -size : size;
}

void Quantiles::add(double value) {
  least_ = count_ == 0 ? value : std::min(least_, value);
  most_ = count_ == 0 ? value : std::max(most_, value);
  if (++count_ <= kExact) {
    few_.push_back(value);
    return;
  }
  for (const double before : few_) put(before);
  few_ = {};
  put(value);
}

double Quantiles::at(double share) const {
  if (count_ == 0) return 0;
  if (share <= 0) return least_;
  if (share >= 1) return most_;
  const double rank = share * static_cast<double>(count_ - 1);
  if (!few_.empty()) {
    std::vector<double> sorted = few_;
    std::sort(sorted.begin(), sorted.end());
    const auto below = static_cast<std::size_t>(rank);
    const std::size_t above = std::min(below + 1, sorted.size() - 1);
    return sorted[below] + (rank - static_cast<double>(below)) * (sorted[above] - sorted[below]);
  }
  std::uint64_t seen = 0;
  for (const auto& [bucket, n] : buckets_) {
    seen += n;
    if (static_cast<double>(seen) > rank) return std::clamp(middle_of(bucket), least_, most_);
  }
  return most_;
}

}  // namespace sinew::sweep
