#include "apps/learn/landing_school.hpp"

#include <algorithm>

namespace sinew::learning {
namespace {

using control::LandingActions;
using control::LandingPolicy;
using control::LandingView;
using control::LandingWish;

constexpr std::uint64_t kTrialSeeds = std::uint64_t{1} << 40;  // seeds of trials; those of evaluations are below
constexpr std::uint64_t kEveryFlight = 20, kFlightsLater = 5;  // improves after each of the first, then after some
constexpr std::uint32_t kExploring = 0x1ea4;                   // stream of random numbers

std::uint64_t trial_seed(std::uint64_t seed, std::uint64_t trial) { return kTrialSeeds + seed * 100'000 + trial; }

double random_action(const learn::Actions& actions, math::Random& random) {
  const auto values = actions.values();
  if (actions.is_discrete()) return values[random.below(static_cast<std::uint32_t>(values.size()))];
  return random.uniform(values[0], values[1]);
}

}  // namespace

std::string to_string(Variant variant) {
  return variant == Variant::batch ? "batch" : variant == Variant::online ? "online" : "continuous";
}

/// What a decision was made on, and what it was.
struct LandingSchool::Memory {
  LandingView view;
  LandingWish wish;
  bool there = false;
};

LandingSchool::LandingSchool(Variant variant, std::uint64_t seed, const SchoolOptions& options)
    : variant_(variant),
      seed_(seed),
      options_(options),
      policy_(variant == Variant::continuous ? LandingActions::continuous : LandingActions::discrete),
      aside_(policy_.aside),
      down_(policy_.down) {}

/// With the flights that it has behind it: at first any action, later mostly the best.
LandingWish LandingSchool::explore(const LandingView& view, math::Random& random) {
  double share = options_.explore_first;
  for (std::uint64_t i = 0; i < trials_ && share > options_.explore_least; ++i) share *= options_.explore_decay;
  if (variant_ == Variant::batch || trials_ == 0) share = 1;
  if (held_ == 0) {
    held_ = 1 + static_cast<int>(random.below(4));  // the same for some decisions: single ones hardly move the vehicle
    for (double& v : kept_.aside_mps) v = random_action(policy_.aside.actions(), random) * (random.below(2) ? 1 : -1);
    kept_.sink_mps = random_action(policy_.down.actions(), random);
  }
  --held_;
  if (share >= 1) return kept_;
  LandingWish wish = policy_.wish(view);
  if (variant_ == Variant::continuous) {
    const auto noisy = [&](double& action, const learn::Actions& actions, double least) {
      const double half = 0.5 * (actions.values()[1] - actions.values()[0]);
      action = std::clamp(action + options_.noise * share * half * random.normal(), least, actions.values()[1]);
    };
    for (double& v : wish.aside_mps) noisy(v, policy_.aside.actions(), -policy_.aside.actions().values()[1]);
    noisy(wish.sink_mps, policy_.down.actions(), policy_.down.actions().values()[0]);
    return wish;
  }
  for (std::size_t i = 0; i < 2; ++i)
    if (random.uniform() < share) wish.aside_mps[i] = kept_.aside_mps[i];
  if (random.uniform() < share) wish.sink_mps = kept_.sink_mps;
  return wish;
}

double LandingSchool::cost_aside(double far, double rate_mps) const {
  return far / (1 - far) * LandingPolicy::kNear_m + options_.near_cost * far + options_.rate_cost * rate_mps * rate_mps;
}

void LandingSchool::remember(const Memory& before, const LandingView& now) {
  if (!before.view.known()) return;
  for (std::size_t i = 0; i < 2; ++i) {
    learn::Transition t;
    bool mirrored = false, next_mirrored = false;
    t.state = LandingPolicy::state_aside(before.view, i, mirrored);
    t.next = LandingPolicy::state_aside(now, i, next_mirrored);
    t.action = mirrored ? -before.wish.aside_mps[i] : before.wish.aside_mps[i];
    const auto range = policy_.aside.actions().values();
    if (t.action < range.front() - 1e-9 || t.action > range.back() + 1e-9) continue;  // away from the pad: not learned
    t.last = !now.known();
    t.reward = t.last ? -1 / (1 - options_.aside.discount) : -cost_aside(t.next[0], now.offset_mps(i));
    aside_.add(t);
  }
  if (before.view.blind() || now.blind() || !now.known()) return;  // the end, if there is one, is remembered later
  learn::Transition t;
  t.state = LandingPolicy::state_down(before.view);
  t.next = LandingPolicy::state_down(now);
  t.action = before.wish.sink_mps;
  t.reward = -options_.step_cost;
  down_.add(t);
}

void LandingSchool::remember_end(const Memory& last, const FlightResult& result) {
  if (!last.there) return;
  learn::Transition t;
  t.state = LandingPolicy::state_down(last.view);
  t.action = last.wish.sink_mps;
  t.last = true;
  const double share = result.touched && !result.crashed ? result.error_m / options_.good_m : 1;
  const bool hard = result.touched && result.speed_mps > options_.good_mps;
  t.reward = -options_.step_cost - options_.end_cost * (hard ? 1 : std::min(1.0, share * share));
  down_.add(t);
}

hal::Result<FlightResult> LandingSchool::trial() {
  FlightOptions flight;
  flight.seed = trial_seed(seed_, trials_);
  flight.brief = true;
  flight.most_s = options_.most_s;
  auto made = LandingFlight::create(flight);
  if (!made) return made.error();
  LandingFlight& f = **made;
  math::Random random(seed_, kExploring, trials_);
  Memory before, last_seeing;
  held_ = 0;
  while (f.next_decision()) {
    if (before.there) remember(before, f.view());
    before = {f.view(), explore(f.view(), random), true};
    if (f.view().known() && !f.view().blind()) last_seeing = before;
    f.act(before.wish);
  }
  remember_end(last_seeing, f.result());
  ++trials_;
  const bool often = trials_ <= kEveryFlight || trials_ % kFlightsLater == 0;  // later a single flight says little new
  if (variant_ != Variant::batch && often) improve();
  return f.result();
}

void LandingSchool::improve() {
  if (learned_ == trials_) return;
  learned_ = trials_;
  learn::LearnOptions aside = options_.aside, down = options_.down;
  if (variant_ != Variant::batch) aside.most_iterations = down.most_iterations = options_.iterations;
  aside_.improve(policy_.aside, aside);
  down_.improve(policy_.down, down);
}

const LandingPolicy& LandingSchool::policy() {
  improve();
  return policy_;
}

hal::Result<FlightResult> fly_policy(const LandingPolicy& policy, const FlightOptions& options,
                                     std::vector<math::Vec3>* path) {
  auto made = LandingFlight::create(options);
  if (!made) return made.error();
  while ((*made)->next_decision()) (*made)->act(policy.wish((*made)->view()));
  if (path) *path = (*made)->path();
  return (*made)->result();
}

std::string policy_file(const LandingPolicy& policy, const std::string& about) {
  std::string text = "# " + about + "\n[landing]\n";
  text += policy.aside.actions().is_discrete() ? "actions = \"discrete\"\n" : "actions = \"continuous\"\n";
  text += "aside = \"" + control::weights_text(policy.aside.weights()) + "\"\n";
  return text + "down = \"" + control::weights_text(policy.down.weights()) + "\"\n";
}

}  // namespace sinew::learning
