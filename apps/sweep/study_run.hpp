#pragma once
// A study: cases that are functions of one program, and what came of them in one file.
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "apps/sweep/results_file.hpp"

namespace sinew::sweep {

struct StudyRun {
  std::string program{};  // "sinew-learn": whose messages they are
  std::string what{};     // before the bar of its progress
  std::string results{};  // path of the file of results; its folder is made
  Identity identity{};
  unsigned jobs = 0;         // at once; 0: one for each processor
  double patience_s = 7200;  // of real time, after which a case counts as hanging
  /// The result of a case, an object; called in a process of its own. `problem` not empty: it has none, and why.
  std::function<Json(std::uint64_t number, std::string& problem)> run{};
  /// What a case is in a message; without it: "case 17".
  std::function<std::string(std::uint64_t number)> name{};
};

enum class StudyEnd : std::uint8_t { whole, interrupted, failed };

/// Runs the cases that the file does not have, and sorts the file once it has them all. A signal ends it after what is
/// said on standard error; the same call goes on. Errors: failed, with a line on standard error: the file (see
/// ResultsFile::open), a case without a result (its name, how its process ended, what it wrote to standard error).
/// Thread:  the only one of the process.
StudyEnd run_study(const StudyRun& study);

/// The results of all cases that a file has, in the order of their numbers. Errors: false, with `why`.
bool read_cases(const std::string& path, std::vector<Json>& cases, std::string& why);

}  // namespace sinew::sweep
