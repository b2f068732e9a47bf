#include "apps/learn/study.hpp"

#include <algorithm>
#include <cmath>

#include "apps/sweep/statistics.hpp"

namespace sinew::learning {
namespace {

constexpr std::uint64_t kPaths = 6;  // flights whose path is kept

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n % 2 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

double quantile(std::vector<double> values, double share) {
  sweep::Quantiles q;
  for (const double v : values) q.add(v);
  return q.at(share);
}

double rounded(double v, double unit) { return std::round(v / unit) * unit; }

app::Json to_json(const Evaluation& e) {
  return {{"trials", e.trials},
          {"starts", e.starts},
          {"good", e.good},
          {"crashed", e.crashed},
          {"not_landed", e.lost},
          {"error_m", median(e.error_m)},
          {"error_95_m", quantile(e.error_m, 0.95)},
          {"speed_mps", median(e.speed_mps)},
          {"speed_most_mps", quantile(e.speed_mps, 1)},
          {"landing_s", median(e.landing_s)}};
}

/// Flights of the policy as lists of places.
app::Json paths_of(const control::LandingPolicy& policy, std::string& why) {
  app::Json all = app::Json::array();
  for (std::uint64_t i = 0; i < kPaths; ++i) {
    std::vector<math::Vec3> path;
    const auto flown = fly_policy(policy, {.seed = kUnseenSeeds + i, .brief = true, .keep_path = true}, &path);
    if (!flown) return why = flown.error().where, app::Json();
    app::Json one = app::Json::array();
    for (const math::Vec3& p : path) one.push_back({rounded(p.x, 1e-3), rounded(p.y, 1e-3), rounded(p.z, 1e-3)});
    all.push_back(std::move(one));
  }
  return all;
}

}  // namespace

hal::Result<Evaluation> evaluate(const control::LandingPolicy& policy, std::uint64_t starts, bool brief) {
  Evaluation e;
  e.starts = starts;
  for (std::uint64_t i = 0; i < starts; ++i) {
    const auto flown = fly_policy(policy, {.seed = kUnseenSeeds + i, .brief = brief});
    if (!flown) return flown.error();
    e.good += flown->good;
    e.crashed += flown->crashed;
    e.lost += flown->lost;
    if (!flown->touched) continue;
    e.error_m.push_back(flown->error_m);
    e.speed_mps.push_back(flown->speed_mps);
    e.landing_s.push_back(flown->landing_s);
  }
  return e;
}

app::Json identity(const StudyOptions& o) {
  app::Json variants = app::Json::array();
  for (const Variant v : o.variants) variants.push_back(to_string(v));
  return {{"study", "landing"},           {"variants", variants}, {"seeds", o.seeds},
          {"trials", o.trials},           {"every", o.every},     {"curve_starts", o.curve_starts},
          {"goal_trials", o.goal_trials}, {"starts", o.starts}};
}

app::Json run_case(const StudyOptions& o, const StudyCase& which, std::string& why) {
  LandingSchool school(which.variant, which.seed);
  app::Json result{{"variant", to_string(which.variant)}, {"seed", which.seed}, {"goal_trials", o.goal_trials}};
  std::string outcomes;  // of the trials: g good, b touched down but not good, l did not land
  app::Json curve = app::Json::array();
  while (school.trials() < o.trials) {
    const auto flown = school.trial();
    if (!flown) return why = flown.error().where, app::Json();
    outcomes += flown->good ? 'g' : flown->lost ? 'l' : 'b';
    const bool goal = school.trials() == std::min(o.goal_trials, o.trials);
    if (!goal && school.trials() != o.trials && school.trials() % o.every != 0) continue;
    auto seen = evaluate(school.policy(), goal ? o.starts : o.curve_starts, true);
    if (!seen) return why = seen.error().where, app::Json();
    seen->trials = school.trials();
    curve.push_back(to_json(*seen));
    if (!goal) continue;
    result["good_after_goal"] = seen->good;
    result["policy"] = policy_file(school.policy(), "");
    result["paths"] = paths_of(school.policy(), why);
    if (!why.empty()) return {};
  }
  result["trials"] = outcomes;
  result["curve"] = std::move(curve);
  return result;
}

}  // namespace sinew::learning
