#pragma once
// The search for a walk's numbers, and for the poses of a motion.
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/gait/gait_setup.hpp"
#include "motion/kick_way.hpp"

namespace sinew::gait {

/// A number of the walk, of a kick from a stand, or of a motion's poses ("push up/knee": degrees; of both sides, or
/// with l_ or r_ of one; "push up/duration_s"), and between what it is searched.
struct Searched {
  std::string name;
  double least = 0, most = 0;
};

/// What is searched for; the walk, where neither is said.
struct SearchFor {
  std::string motion{};                   // "rise_front": its poses
  std::optional<motion::KickWay> kick{};  // its numbers
  bool within_step = false;               // of the walk's kick, not of the one from a stand
};

struct SearchOptions : SearchFor {
  std::vector<Searched> numbers{};
  std::uint64_t seed = 1;
  std::uint64_t generations = 20, samples = 12, first_generation = 0;
  std::uint64_t runs = 6;    // of each sample: courses in turn; all samples of a generation have the same seeds
  double lasts_s = 8;        // of a run
  double push_mps = 0.12;    // every 3 s, in a direction that the seed draws; 0: none
  std::uint64_t pushes = 0;  // of each sample, beside its walks: as the table's, each way in turn
  double push_along_mps = 0.45, push_side_mps = 0.3;  // their changes of speed
  double sigma = 0.07;                                // of the first generation, as a part of each range
};

/// Of the walk, or of a kick.
std::vector<Searched> standard_numbers(const SearchFor& what);
/// Of a motion: the duration of each pose, from half to twice of what it is, and the joints that a pose moves,
/// `range_deg` to both sides within their stops; `poses`: of these only. Joints of two sides that are the same stay the
/// same, and a pose that leaves a joint as it was goes on to do so. Errors: nothing, with `why`: no such motion or
/// pose.
std::vector<Searched> numbers_of_motion(const GaitSetup& setup, const std::string& motion,
                                        const std::vector<std::string>& poses, double range_deg, std::string& why);
/// "lift_m:0.01:0.03,period_s:0.2:0.3". Errors: nothing, with `why`: a name that it does not have, no range.
std::vector<Searched> parse_searched(const GaitSetup& setup, const SearchFor& what, const std::string& text,
                                     std::string& why);

/// What a setup costs, 0 being the best.
/// A walk: 1 to 2 for a run that falls, the sooner the more; otherwise how far its speeds are from the wanted ones, its
/// odometry from the truth, and how much it sways. To the mean of the walks comes the part of the pushes that it fell
/// by. Rising: how far from standing it was, the end counting most, and half of 1 for a run that does not stand in the
/// end; from its back also how far from its front it remained. Getting down: the blow, and half of 1 for a run that
/// does not lie at rest on its front in the end. Turning from a side: how far the torso then is from its front, and
/// 0.05 a second. A kick, with both feet in turn: how much slower than 1.4 m/s the ball is as a part of that, 0.3 more
/// below 1.25 m/s, and up to half of 1 for a direction more than 4 degrees off; 1 for a missed ball, 1.5 for a fall.
double cost_of(const GaitSetup& setup, const SearchOptions& options, std::uint64_t generation, std::string& why);

/// The samples of one generation, each as a setup.
std::vector<GaitSetup> setups_of(const GaitSetup& setup, const SearchOptions& options,
                                 const std::vector<std::vector<double>>& samples);
/// Where the setup's own numbers are in their ranges, 0 to 1.
std::vector<double> start_of(const GaitSetup& setup, const SearchOptions& options);

}  // namespace sinew::gait
