#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "apps/learn/study.hpp"
#include "apps/sweep/statistics.hpp"
#include "apps/view/plot.hpp"

namespace sinew::learning {
namespace {

using Values = std::vector<double>;

/// The median of values that are sorted, and an interval that has the true median with at least 95 % confidence: from
/// the kth smallest to the kth largest value, as the binomial distribution says (of 10: the second). Fewer than 6
/// values have none: then the least and the most.
struct Band {
  double low = 0, middle = 0, high = 0;
};

Band band(Values v) {
  if (v.empty()) return {};
  std::sort(v.begin(), v.end());
  const std::size_t n = v.size();
  double term = 1, below = 0;  // C(n, k) / 2^n, and the sum of those before
  for (std::size_t i = 0; i < n; ++i) term /= 2;
  std::size_t k = 0;
  while (k < n / 2 && below + term <= 0.025) {
    below += term;
    term *= static_cast<double>(n - k) / static_cast<double>(k + 1);
    ++k;
  }
  const std::size_t at = k == 0 ? 0 : k - 1;
  return {v[at], n % 2 ? v[n / 2] : 0.5 * (v[n / 2 - 1] + v[n / 2]), v[n - 1 - at]};
}

std::vector<std::string> variants_in(const std::vector<app::Json>& cases) {
  std::vector<std::string> names;
  for (const app::Json& c : cases) {
    const std::string name = c.value("variant", "");
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  return names;
}

/// By number of trials, a value of each learning seed.
std::map<double, Values> curve_of(const std::vector<app::Json>& cases, const std::string& variant, const char* key,
                                  bool share) {
  std::map<double, Values> all;
  for (const app::Json& c : cases) {
    if (c.value("variant", "") != variant) continue;
    for (const app::Json& e : c.value("curve", app::Json::array())) {
      const double value = e.value(key, 0.0);
      all[e.value("trials", 0.0)].push_back(share ? 100 * value / std::max(1.0, e.value("starts", 1.0)) : value);
    }
  }
  return all;
}

app::Plot curve_plot(const std::vector<app::Json>& cases, const std::string& variant) {
  app::Plot plot;
  std::size_t seeds = 0;
  app::Series low{"low end of the 95 % interval of the median"}, middle{"median of the learning seeds"},
      high{"high end"};
  app::Series worst{"worst seed"};
  for (const auto& [trials, values] : curve_of(cases, variant, "good", true)) {
    const Band b = band(values);
    low.points.emplace_back(trials, b.low);
    middle.points.emplace_back(trials, b.middle);
    high.points.emplace_back(trials, b.high);
    worst.points.emplace_back(trials, *std::min_element(values.begin(), values.end()));
    seeds = std::max(seeds, values.size());
  }
  plot.title =
      fmt::format("{}: unseen starts landed within 0.15 m at under 0.5 m/s, {} learning seeds", variant, seeds);
  app::Series goal{"goal 95 %"};
  if (!middle.points.empty()) goal.points = {{0, 95}, {middle.points.back().first, 95}};
  plot.x_label = "trials";
  plot.y_label = "landed, %";
  plot.series = {middle, low, high, worst, goal};
  return plot;
}

/// How the flights of learning themselves ended, some at a time, those of all learning seeds together.
app::Plot trial_plot(const std::vector<app::Json>& cases, const std::string& variant) {
  constexpr std::size_t kTogether = 10;
  std::vector<std::uint64_t> good, all;
  for (const app::Json& c : cases) {
    if (c.value("variant", "") != variant) continue;
    const std::string outcomes = c.value("trials", "");
    for (std::size_t i = 0; i < outcomes.size(); ++i) {
      const std::size_t at = i / kTogether;
      if (at >= all.size()) good.push_back(0), all.push_back(0);
      good[at] += outcomes[i] == 'g';
      ++all[at];
    }
  }
  app::Series share{"landed"}, low{"low end of the 95 % interval"}, high{"high end"};
  for (std::size_t at = 0; at < all.size(); ++at) {
    const double x = static_cast<double>(kTogether) * (static_cast<double>(at) + 0.5);
    const sweep::Interval interval = sweep::wilson_95(good[at], all[at]);
    share.points.emplace_back(x, 100 * static_cast<double>(good[at]) / static_cast<double>(all[at]));
    low.points.emplace_back(x, 100 * interval.low);
    high.points.emplace_back(x, 100 * interval.high);
  }
  app::Plot plot;
  plot.title = fmt::format("{}: trials themselves, with what they explore, ten at a time", variant);
  plot.x_label = "trials";
  plot.y_label = "landed, %";
  plot.series = {share, low, high};
  return plot;
}

/// Of the first learning seed of the variant: from above, or from the side.
app::Plot path_plot(const std::vector<app::Json>& cases, const std::string& variant, bool from_above) {
  app::Plot plot;
  for (const app::Json& c : cases) {
    if (c.value("variant", "") != variant) continue;
    plot.title = fmt::format("{}, learning seed {}, after {} trials: paths {}", variant, c.value("seed", 0),
                             c.value("goal_trials", 0), from_above ? "from above" : "from the side");
    int number = 0;
    for (const app::Json& path : c.value("paths", app::Json::array())) {
      app::Series line{fmt::format("start {}", ++number)};
      for (const app::Json& p : path) {
        const double x = p[0], y = p[1], z = p[2];
        if (from_above)
          line.points.emplace_back(x, y);
        else
          line.points.emplace_back(x, z);
      }
      plot.series.push_back(std::move(line));
    }
    break;
  }
  plot.x_label = "x, m";
  plot.y_label = from_above ? "y, m" : "height, m";
  return plot;
}

}  // namespace

std::string study_table(const std::vector<app::Json>& cases) {
  std::string text = fmt::format("{:<11} {:>6} {:>6}  {:>18}  {:>6}  {:>9} {:>9}  {:>9} {:>9}\n", "variant", "trials",
                                 "seeds", "landed %, median", "worst", "error m", "95 %", "speed", "landing s");
  for (const std::string& variant : variants_in(cases)) {
    const auto good = curve_of(cases, variant, "good", true);
    const auto field = [&](const char* key, double trials) {
      return band(curve_of(cases, variant, key, false)[trials]).middle;
    };
    for (const auto& [trials, values] : good) {
      const Band b = band(values);
      text += fmt::format(
          "{:<11} {:>6} {:>6}  {:>5.0f} ({:.0f} to {:.0f}){:>{}}  {:>6.0f}  {:>9.3f} {:>9.3f}  {:>9.2f} {:>9.1f}\n",
          variant, trials, values.size(), b.middle, b.low, b.high, "",
          std::max<int>(0, 18 - 11 - static_cast<int>(fmt::format("{:.0f}{:.0f}", b.low, b.high).size())),
          *std::min_element(values.begin(), values.end()), field("error_m", trials), field("error_95_m", trials),
          field("speed_mps", trials), field("landing_s", trials));
    }
  }
  return text;
}

Best best_of(const std::vector<app::Json>& cases) {
  Best best;
  for (const std::string& variant : variants_in(cases)) {
    Values landed;
    for (const app::Json& c : cases) {
      if (c.value("variant", "") != variant) continue;
      for (const app::Json& e : c.value("curve", app::Json::array()))
        if (e.value("trials", 0) == c.value("goal_trials", 0))
          landed.push_back(100 * e.value("good", 0.0) / std::max(1.0, e.value("starts", 1.0)));
    }
    const double middle = band(landed).middle;
    if (best.variant.empty() || middle > best.landed) best = {variant, middle};
  }
  return best;
}

std::string study_plots(const std::vector<app::Json>& cases, const std::string& folder, const std::string& kind) {
  std::vector<app::Plot> curves, paths;
  for (const std::string& variant : variants_in(cases)) {
    curves.push_back(curve_plot(cases, variant));
    curves.push_back(trial_plot(cases, variant));
    paths.push_back(path_plot(cases, variant, true));
    paths.push_back(path_plot(cases, variant, false));
  }
  const std::string why = app::write_plots(fmt::format("{}/learning-curves.{}", folder, kind), curves);
  return why.empty() ? app::write_plots(fmt::format("{}/learning-paths.{}", folder, kind), paths) : why;
}

}  // namespace sinew::learning
