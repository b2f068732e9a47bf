#pragma once
// How well soccer::Locator does on walks without pictures.
#include <string>
#include <vector>

#include "apps/locate/field_walk.hpp"
#include "soccer/world/locator.hpp"

namespace sinew::locate {

/// Errors of believed poses against the truth.
struct PoseErrors {
  std::vector<double> off_m, off_rad;                 // after the better of both halves
  std::uint64_t poses = 0, wrong_half = 0, lost = 0;  // lost: not found, as it says itself
  std::uint64_t beyond = 0;                           // not counted: off the carpet
  void add(const msg::FieldPose& believed, const soccer::FieldAt& truth);
  void add(const PoseErrors& other);
};
std::string text(PoseErrors errors);

struct StudyOptions {
  std::uint64_t first_seed = 1, runs = 100;
  double seconds = 60;
  double settle_s = 10;  // counted from then on
  soccer::LocatorOptions locator;
  WalkErrors errors;
};

/// Walks that begin somewhere in the own half.
PoseErrors study_walks(const StudyOptions& options);

struct Kidnappings {
  std::vector<double> found_s;       // up to half a turn, and kept for 2 s; infinite: not within the time
  std::vector<double> right_half_s;  // as above, in the right half
};
/// After 15 s it is carried. `reentry`: to the touch line of its own half, as the referee does, and it knows; else to
/// anywhere, and it is told nothing, but after 10 s a mate says twice a second where the ball is.
Kidnappings study_kidnappings(const StudyOptions& options, bool reentry);

}  // namespace sinew::locate
