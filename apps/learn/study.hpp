#pragma once
// A study of learning to land: each variant with many learning seeds, each evaluated along the way.
#include <string>
#include <vector>

#include "apps/command/json.hpp"
#include "apps/learn/landing_school.hpp"

namespace sinew::learning {

/// Seeds of the worlds of evaluations: no trial has them, so their starts, wind, mass and motors are unseen.
inline constexpr std::uint64_t kUnseenSeeds = 500'001;

struct StudyOptions {
  std::vector<Variant> variants{kVariants.begin(), kVariants.end()};
  std::uint64_t seeds = 10;         // learning seeds 1 to this, for each variant
  std::uint64_t trials = 100;       // flights to learn from
  std::uint64_t every = 30;         // trials from evaluation to evaluation
  std::uint64_t curve_starts = 10;  // unseen starts of each evaluation
  std::uint64_t goal_trials = 90;   // the policy of then is kept, and has more starts:
  std::uint64_t starts = 100;
};

/// What is learned by whom: cases count through the variants with the first seed, then with the next: an
/// interrupted study has as many seeds of each.
struct StudyCase {
  Variant variant{};
  std::uint64_t seed = 1;
};
inline std::uint64_t cases_of(const StudyOptions& o) { return o.variants.size() * o.seeds; }
inline StudyCase case_of(const StudyOptions& o, std::uint64_t number) {
  return {o.variants[static_cast<std::size_t>(number % o.variants.size())], number / o.variants.size() + 1};
}

/// What the unseen starts came to.
struct Evaluation {
  std::uint64_t trials = 0, starts = 0, good = 0, crashed = 0, lost = 0;
  std::vector<double> error_m, speed_mps, landing_s;  // of those that touched down
};
/// Flights begin as those of trials: with little waiting before the landing. `brief` false: whole flights, to rest.
/// Errors:  those of the world.
hal::Result<Evaluation> evaluate(const control::LandingPolicy& policy, std::uint64_t starts, bool brief);

/// Learns and evaluates one case. The result has its curve, the policy after goal_trials as text, and some paths.
/// Empty, with `why`: it could not.
app::Json run_case(const StudyOptions& options, const StudyCase& which, std::string& why);

/// All that decides the results.
app::Json identity(const StudyOptions& options);

/// Result lines of a study as a table.
std::string study_table(const std::vector<app::Json>& cases);
/// The variant whose median of the learning seeds is highest after goal_trials, and that median in %.
struct Best {
  std::string variant;
  double landed = 0;
};
Best best_of(const std::vector<app::Json>& cases);
/// Curves and paths as plots: learning-curves and learning-paths in `folder`, with the ending `kind` (svg, png). Empty:
/// written; else why not.
std::string study_plots(const std::vector<app::Json>& cases, const std::string& folder, const std::string& kind);

}  // namespace sinew::learning
