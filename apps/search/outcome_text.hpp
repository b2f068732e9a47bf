#pragma once
// An outcome as one line of JSON, from the process that flies to the process that searches.
#include "apps/search/case_flight.hpp"

namespace sinew::search {

std::string to_json(const Case& c, const Outcome& outcome);
/// Nothing when the line is not what to_json() writes.
std::optional<Outcome> parse_outcome(const std::string& line);

}  // namespace sinew::search
