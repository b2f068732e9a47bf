#pragma once
// What one `sinew run --json` in a process of its own says as a result of a sweep.
#include <optional>
#include <string>

#include "apps/sweep/case_result.hpp"
#include "apps/sweep/process_pool.hpp"

namespace sinew::app {

struct RunEnd {
  sweep::CaseResult result{};  // the same bytes for the same run
  std::string recording{};     // its path; empty: none
  std::string not_begun{};     // why it is no result: the run was refused, or there was no process
  bool interrupted = false;    // it is no result: it was ended from outside
};

/// `run`: its options. `patience_s`: of the pool.
RunEnd end_of_run(const std::string& run, const sweep::JobResult& job, double patience_s);

}  // namespace sinew::app
