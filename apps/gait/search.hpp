#pragma once
// The search for a walk's numbers, and for the poses of a motion that turns a lying body over.
#include <functional>
#include <string>
#include <vector>

#include "apps/gait/gait_setup.hpp"

namespace sinew::gait {

/// A number, and between what it is searched.
struct Searched {
  std::string name;  // of the walk; or MOTION/POSE/JOINT (rad) and MOTION/POSE/duration_s, poses counted from 0
  double least = 0, most = 0;
};

struct SearchOptions {
  std::vector<Searched> numbers{};  // empty: standard_numbers()
  std::uint64_t seed = 1;
  std::uint64_t generations = 20, samples = 12, first_generation = 0;
  std::uint64_t runs = 6;  // of each sample: courses in turn; all samples of a generation have the same seeds
  double lasts_s = 8;      // of a run
  double push_mps = 0.12;  // every 3 s, in a direction that the seed draws; 0: none
  double sigma = 0.07;     // of the first generation, as a part of each range
  // In place of a walk: a motion that takes a body from how it lies onto its front or back.
  std::string motion{};
  motion::FallWay lies_on = motion::FallWay::left, ends_on = motion::FallWay::front;
};

std::vector<Searched> standard_numbers();
/// "lift_m:0.01:0.03,period_s:0.2:0.3". Errors: nothing, with `why`: a name that the walk has not, no range.
std::vector<Searched> parse_searched(const std::string& text, std::string& why);

/// All joints but the head's, and the durations, of all poses of a motion of the setup: around what they are, by
/// `range_rad` either way, within the joints' limits.
std::vector<Searched> pose_numbers(const GaitSetup& setup, const std::string& motion, double range_rad);

/// A motion costs how far the torso then is from lying as wanted, 0 to 1, and 0.05 a second.
/// What a walk with these numbers costs: for a run that falls 1 to 2, the sooner the more; otherwise how far its speeds
/// are from the wanted ones, its odometry from the truth, and how much it sways.
double cost_of(const GaitSetup& setup, const SearchOptions& options, std::uint64_t generation, std::string& why);

/// The samples of one generation, each as a setup.
std::vector<GaitSetup> setups_of(const GaitSetup& setup, const std::vector<Searched>& numbers,
                                 const std::vector<std::vector<double>>& samples);
/// Where the setup's own numbers are in their ranges, 0 to 1.
std::vector<double> start_of(const GaitSetup& setup, const std::vector<Searched>& numbers);

}  // namespace sinew::gait
