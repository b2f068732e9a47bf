#include "apps/run/miss_cause.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace sinew::app {
namespace {

using Measure = WorldReport::Measure;

constexpr double kMostSaturated_percent = 1, kMostEstimate_m = 0.1;

std::vector<Measure> conditions(const MissEvidence& e) {
  std::vector<Measure> all;
  if (e.report && e.report->verdict) all = e.report->verdict->conditions;
  const auto add = [&](const char* label, const char* unit, double value, double most) {
    all.push_back({.key = label, .label = label, .unit = unit, .value = value, .at_most = most, .at_least = {}});
  };
  if (e.saturated) add("actuators at a limit", "% of the time", 100 * *e.saturated, kMostSaturated_percent);
  if (e.estimate) add("estimate off by up to", "m", e.estimate->worst_m, kMostEstimate_m);
  if (e.real_time && e.report && e.report->frames + e.report->render_late > 0)
    add("frames late", "%",
        100.0 * static_cast<double>(e.report->render_late) /
            static_cast<double>(e.report->frames + e.report->render_late),
        e.frames_late_percent_bound);
  return all;
}

std::string what_missed(const MissEvidence& e) {
  const Measure* worst = nullptr;
  if (e.report && e.report->verdict)
    for (const Measure& m : e.report->verdict->measures)
      if (over_limit(m) >= 1 && (!worst || over_limit(m) > over_limit(*worst))) worst = &m;
  if (worst) return in_words(*worst) + "; ";
  if (!e.unfinished.empty()) return fmt::format("the run ended after {:.1f} s while {}; ", e.ended_s, e.unfinished);
  return {};
}

std::string cause(const MissEvidence& e) {
  if (!e.failsafes.empty()) return "failsafe " + e.failsafes.front() + " acted";
  if (e.report)
    for (const WorldReport::Fault& f : e.report->faults)
      if (f.affected > 0) return fmt::format("fault {} struck {} times", f.text, f.affected);
  const std::vector<Measure> all = conditions(e);
  if (all.empty()) return "neither the simulator nor the robot measured any condition";
  const Measure& worst =
      *std::ranges::max_element(all, [](const Measure& a, const Measure& b) { return over_limit(a) < over_limit(b); });
  if (over_limit(worst) > 1) return in_words(worst);
  std::string text = "all conditions were within their limits: ";
  for (const Measure& m : all) text += (&m == &all.front() ? "" : ", ") + in_words(m);
  return text;
}

}  // namespace

std::string miss_cause(const MissEvidence& e) {
  if (!e.ended_early.empty() && !e.unfinished.empty()) return fmt::format("{} while {}", e.ended_early, e.unfinished);
  return what_missed(e) + cause(e);
}

}  // namespace sinew::app
