#include "rt/exec/stats.hpp"

#include <algorithm>
#include <bit>

namespace sinew::rt {

std::size_t Histogram::bucket_of(std::uint64_t ns) noexcept {
  if (ns < kSub) return static_cast<std::size_t>(ns);
  const int shift = static_cast<int>(std::bit_width(ns)) - 5;  // leaves 16..31
  const std::size_t bucket = static_cast<std::size_t>(shift) * kSub + static_cast<std::size_t>(ns >> shift);
  return std::min(bucket, kBuckets - 1);
}

std::uint64_t Histogram::upper_bound(std::size_t bucket) noexcept {
  if (bucket < kSub) return bucket;
  const std::size_t shift = bucket / kSub - 1;
  return (std::uint64_t{kSub + bucket % kSub + 1} << shift) - 1;
}

void Histogram::add(Duration d) noexcept {
  const std::int64_t ns = std::max<std::int64_t>(d.count(), 0);
  bucket_[bucket_of(static_cast<std::uint64_t>(ns))].add();
  if (count() == 0 || ns < min_.value()) min_.set(ns);
  if (ns > max_.value()) max_.set(ns);
  sum_.add(ns);
  count_.add();
}

double Histogram::mean_ns() const noexcept {
  const std::uint64_t n = count();
  return n ? static_cast<double>(sum_.value()) / static_cast<double>(n) : 0.0;
}

void GapStats::add(Duration length, std::uint32_t times) noexcept {
  if (count.value() == 0 || length.count() < min_ns.value()) min_ns.set(length.count());
  max_ns.set(std::max(max_ns.value(), std::int64_t{length.count()}));
  count.add(times);
}

Duration Histogram::quantile(double q) const noexcept {
  std::uint64_t total = 0;  // sum of the buckets, not count_: a reader may see the writer between the two
  for (const auto& b : bucket_) total += b.value();
  if (total == 0) return Duration{0};
  const double wanted = std::clamp(q, 0.0, 1.0) * static_cast<double>(total);
  auto rank = static_cast<std::uint64_t>(wanted);
  if (static_cast<double>(rank) < wanted || rank == 0) ++rank;
  std::uint64_t seen = 0;
  for (std::size_t i = 0; i < kBuckets; ++i) {
    seen += bucket_[i].value();
    if (seen >= rank && i + 1 < kBuckets) return std::min(Duration{static_cast<std::int64_t>(upper_bound(i))}, max());
  }
  return max();
}

}  // namespace sinew::rt
