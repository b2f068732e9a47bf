#include "apps/search/shrink.hpp"

#include <cmath>

namespace sinew::search {
namespace {

/// In whole tenths, this share of the way to 1.
double nearer_to_one(double factor, double share) { return std::floor(10 * (factor + share * (1 - factor))) / 10; }

void without(const Case& c, std::vector<Case>& all) {
  if (c.faults.size() > 1) all.emplace_back(c).faults.clear();
  if (c.faults.size() > 3) {  // half of them at once
    const auto middle = static_cast<std::ptrdiff_t>(c.faults.size() / 2);
    Case& first = all.emplace_back(c);
    first.faults.erase(first.faults.begin() + middle, first.faults.end());
    Case& second = all.emplace_back(c);
    second.faults.erase(second.faults.begin(), second.faults.begin() + middle);
  }
  for (std::size_t i = 0; i < c.faults.size(); ++i) {
    Case& less = all.emplace_back(c);
    less.faults.erase(less.faults.begin() + static_cast<std::ptrdiff_t>(i));
  }
  if (c.stress.size() > 1) all.emplace_back(c).stress.clear();
  for (std::size_t i = 0; i < c.stress.size(); ++i) {
    Case& less = all.emplace_back(c);
    less.stress.erase(less.stress.begin() + static_cast<std::ptrdiff_t>(i));
  }
  if (!c.nominal && c.stress.empty()) {
    Case& less = all.emplace_back(c);
    less.nominal = true;
    less.jitter = 1;
  }
  if (c.gust_mps != 0) all.emplace_back(c).gust_mps = 0;
}

void less(const Case& c, std::vector<Case>& all) {
  for (std::size_t i = 0; i < c.faults.size(); ++i) {
    const std::int64_t length_ms = c.faults[i].length.count() / kMsNs;
    for (const std::int64_t shorter : {length_ms / 2, length_ms * 3 / 4})
      if (shorter >= 1 && shorter < length_ms) all.emplace_back(c).faults[i].length = Duration{shorter * kMsNs};
    const double half = std::floor(c.faults[i].amount / 2);
    if (half >= 2) all.emplace_back(c).faults[i].amount = half;
  }
  for (std::size_t i = 0; i < c.stress.size(); ++i)
    for (const double share : {0.5, 0.25})
      if (const double factor = nearer_to_one(c.stress[i].factor, share); factor > 1 && factor < c.stress[i].factor)
        all.emplace_back(c).stress[i].factor = factor;
}

void rounder(const Case& c, std::vector<Case>& all) {
  for (std::size_t i = 0; i < c.faults.size(); ++i)
    for (const std::int64_t grain : {1000 * kMsNs, 100 * kMsNs, 10 * kMsNs}) {
      const Time from{c.faults[i].from.ns / grain * grain};
      if (from == c.faults[i].from) break;
      all.emplace_back(c).faults[i].from = from;
    }
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    if (c.world > 3) all.emplace_back(c).world = seed;
    if (c.jitter > 3) all.emplace_back(c).jitter = seed;
  }
}

}  // namespace

std::vector<Case> simpler(const Case& c) {
  std::vector<Case> all;
  without(c, all);
  less(c, all);
  rounder(c, all);
  return all;
}

Case shrink(Case failing, const FirstFailing& first_failing) {
  for (;;) {
    const std::vector<Case> candidates = simpler(failing);
    const auto which = first_failing(candidates);
    if (!which) return failing;
    failing = candidates[*which];
  }
}

}  // namespace sinew::search
