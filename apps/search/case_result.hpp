#pragma once
// What a process that flew one case (`sinew-fuzz --case TEXT --json`) says of it by its output and its end.
#include <string>

#include "apps/search/case_flight.hpp"
#include "apps/sweep/process_pool.hpp"

namespace sinew::search {

struct CaseResult {
  Outcome outcome;    // a process that died or hung is a violation, too
  std::string error;  // the case could not be flown: no plant, a wrong case
};

/// `patience`: that of the pool.
CaseResult case_result(const sweep::JobResult& job, hal::Duration patience);

}  // namespace sinew::search
