#pragma once
#include <functional>
#include <optional>

#include "apps/search/case.hpp"

namespace sinew::search {

/// Runs cases in their order. Returns the first one that fails in the same way; none when the budget of flights is used
/// up.
using FirstFailing = std::function<std::optional<std::size_t>(const std::vector<Case>&)>;

/// All cases that are a little simpler than this one, the greatest steps first: without faults, without one of them,
/// without stress, with the robot file's own execution times, without wind; then shorter faults, smaller amounts, less
/// stress; then rounder numbers. Every one is strictly simpler, so shrinking ends.
std::vector<Case> simpler(const Case& c);

/// Follows simpler() for as long as something simpler fails.
Case shrink(Case failing, const FirstFailing& first_failing);

}  // namespace sinew::search
