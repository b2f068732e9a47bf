#pragma once
#include <functional>
#include <string>
#include <vector>

#include "apps/learn/landing_flight.hpp"
#include "learn/lstd_q.hpp"

namespace sinew::learning {

/// How a policy is learned.
enum class Variant : std::uint8_t {
  batch,      // from flights with random actions; no flight uses what was learned
  online,     // after each flight the policy is improved; it flies the next one, with random actions that get rarer
  continuous  // online with continuous actions, to which noise is added that gets weaker
};
inline constexpr std::array kVariants{Variant::continuous, Variant::online, Variant::batch};
std::string to_string(Variant variant);

/// The rewards, which say what a good landing is, and the numbers of learning. Each second costs something; the way
/// aside costs by how far the pad is aside; a landing costs by its error.
struct SchoolOptions {
  double rate_cost = 0.15;  // aside: for each (m/s)^2
  double near_cost = 1;     // aside: of being off at all
  double step_cost = 0.1;   // down: of each decision
  double end_cost = 6;      // of a landing that is off by good_m or more, hard, or did not come to an end
  double good_m = 0.12, good_mps = 0.45;
  learn::LearnOptions aside{.discount = 0.95, .ridge = 1, .prior = -4};
  learn::LearnOptions down{.discount = 0.98, .ridge = 1, .prior = -3};
  double explore_first = 1, explore_decay = 0.94, explore_least = 0.03;  // share of random actions, by flight
  double noise = 0.6;  // of a continuous action, as a share of half its range, at the first flight
  int iterations = 4;  // after each flight
  double most_s = 30;  // of a flight
};

/// One pupil: learns by flights of its own.
/// The same seed gives the same policy, byte for byte, on every machine.
/// Thread:  owner.
class LandingSchool {
 public:
  LandingSchool(Variant variant, std::uint64_t seed, const SchoolOptions& options = {});

  /// One more trial: a flight from a start that no evaluation has, then, but for the batch, learning.
  /// Errors:  those of the world.
  hal::Result<FlightResult> trial();
  /// What was learned so far; of the batch it is learned now.
  const control::LandingPolicy& policy();
  std::uint64_t trials() const { return trials_; }

 private:
  struct Memory;  // of the decision before
  control::LandingWish explore(const control::LandingView& view, math::Random& random);
  void remember(const Memory& before, const control::LandingView& now);
  void remember_end(const Memory& last, const FlightResult& result);
  double cost_aside(double far, double rate_mps) const;
  void improve();

  Variant variant_;
  std::uint64_t seed_;
  SchoolOptions options_;
  control::LandingPolicy policy_;
  learn::PolicyIteration aside_, down_;
  std::uint64_t trials_ = 0, learned_ = 0;
  int held_ = 0;  // decisions for which random actions are still kept
  control::LandingWish kept_;
};

/// Flies a policy; every decision is the best one.
hal::Result<FlightResult> fly_policy(const control::LandingPolicy& policy, const FlightOptions& options,
                                     std::vector<math::Vec3>* path = nullptr);

/// The file of parameters that `sinew run robots/quad/quad_learned.toml --params` takes.
std::string policy_file(const control::LandingPolicy& policy, const std::string& about);

}  // namespace sinew::learning
