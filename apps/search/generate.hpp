#pragma once
#include "apps/search/case.hpp"

namespace sinew::search {

/// The case of a seed: same seed, same modules, same case.
/// Bounds: at most kMostFaults faults of what a device can do wrong (docs/search.md has the table with its lengths and
/// amounts), stress up to kMostStress on up to three modules, in an eighth of the cases up to
/// kHeaviestStress on one, so that periods are overrun, wind up to 2 m/s. A third of the cases has no fault and
/// half of them no stress, so that jitter alone is searched, too.
Case generate(std::uint64_t seed, const std::vector<std::string>& modules);

inline constexpr std::uint32_t kMostFaults = 6;
inline constexpr double kMostStress = 4.0, kHeaviestStress = 16.0;

/// The seed of the run with this number.
std::uint64_t case_seed(std::uint64_t search_seed, std::uint64_t run);

}  // namespace sinew::search
