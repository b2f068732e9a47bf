#pragma once
// Many matches: a sweep of seeds, each match in a process of its own, results in one file.
#include <string>
#include <vector>

#include "apps/match/match_options.hpp"
#include "apps/sweep/case_result.hpp"
#include "rt/module_types.hpp"

namespace sinew::app {

/// What all matches say about the two teams.
struct MatchStatistics {
  std::uint64_t matches = 0, won = 0, drawn = 0, lost = 0, unfinished = 0;  // by A; unfinished ones count nowhere else
  struct Estimate {
    double mean = 0, low = 0, high = 0;  // 95 %
  };
  Estimate points;           // A's share: 1 for a match won, 0.5 for one drawn
  Estimate goal_difference;  // a match
  double p = 1;              // of as uneven wins if neither team is better (two-sided, exact)
};
/// Intervals by the bootstrap over matches: 10000 times as many are drawn with replacement; percentiles 2.5 and 97.5.
/// The same numbers for the same results. Source: B. Efron, "Bootstrap methods", Annals of Statistics 7 (1979).
MatchStatistics statistics_of(const std::vector<sweep::CaseResult>& matches);
/// In words: which team is better, or that these matches do not show it.
std::string verdict_text(const MatchStatistics& s);

/// Plays the matches that the file of results does not have, and prints the table. Exit code 0: all finished; 1: not
/// all; 2: it could not begin.
int run_matches(const MatchOptions& options, const rt::ModuleTypes& types);

}  // namespace sinew::app
