#pragma once
// Tables of what a body can do: many cases on unseen seeds.
#include <string>
#include <vector>

#include "apps/command/json.hpp"
#include "apps/gait/gait_setup.hpp"
#include "apps/gait/walk_trial.hpp"

namespace sinew::gait {

/// Seeds of tables begin here; a search has smaller ones.
inline constexpr std::uint64_t kUnseenSeeds = 500'001;

enum class Kind : std::uint8_t { walk, push, rise, fall, kick, stop, down };
inline constexpr std::array kKinds{Kind::walk, Kind::push, Kind::rise, Kind::fall, Kind::kick, Kind::stop, Kind::down};
std::string to_string(Kind kind);

struct StudyOptions {
  Kind kind = Kind::walk;
  std::uint64_t runs =
      100;  // walk, down: all together; rise, fall, kick, stop: of each way; push: of each direction and speed
  double lasts_s = 60;                                            // of a walk
  std::vector<Course> courses{kCourses.begin(), kCourses.end()};  // of walks, in turn
  std::uint64_t first_seed = kUnseenSeeds;                        // of walks, stops, rising, pushes
  std::vector<double> push_mps{0.1, 0.2, 0.25, 0.3, 0.4, 0.5, 0.6};
  double fall_mps = 1.2;  // of the push that makes it fall
  bool looks = false;     // walks: the head looks to both sides, in place of resting
  double ball_mps = 0.8;  // of the ball that is stopped
};

std::uint64_t cases_of(const StudyOptions& options);
/// One case. Empty, with `why`: it could not be run.
app::Json run_case(const StudyOptions& options, const GaitSetup& setup, std::uint64_t number, std::string& why);
/// What decides the results, beside the files.
app::Json identity(const StudyOptions& options);
/// Results as a table.
std::string study_table(const StudyOptions& options, const std::vector<app::Json>& cases);

}  // namespace sinew::gait
