#include "apps/sweep_runs/sweep_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <span>

#include "apps/sweep/case_text.hpp"
#include "apps/view/plot.hpp"

namespace sinew::app {
namespace {

/// The value of a setting, or of the seed; nothing: the run has none.
std::optional<std::string> value_in(const std::string& run, const std::string& key) {
  if (key == "seed") return sweep::seed_of(run);
  const auto words = sweep::split_words(run).value_or(std::vector<std::string>{});
  for (std::size_t i = 0; i + 1 < words.size(); ++i)
    if (words[i] == "--set" && words[i + 1].starts_with(key + "=")) return words[i + 1].substr(key.size() + 1);
  return std::nullopt;
}

std::vector<std::pair<double, double>> across(double value, double from, double to) {
  return {{from, value}, {to, value}};
}

}  // namespace

void SweepPlot::count(double value) {
  const double share = high_ > low_ ? (value - low_) / (high_ - low_) : 0;
  ++bins_[std::min(static_cast<std::size_t>(share * static_cast<double>(bins_.size())), bins_.size() - 1)];
}

bool SweepPlot::add(const sweep::CaseResult& result, std::string& why) {
  const auto m = std::find_if(result.measures.begin(), result.measures.end(),
                              [&](const auto& one) { return one.name == measure_; });
  if (m == result.measures.end()) return true;
  if (counting_) {
    count(m->value);
    return true;
  }
  limits_ = m->limits;
  all_.add(m->value);
  if (over_.empty()) return true;
  const auto text = value_in(result.run, over_);
  double at = 0;
  if (text) {
    const auto r = std::from_chars(text->data(), text->data() + text->size(), at);
    if (r.ec == std::errc() && r.ptr == text->data() + text->size()) {
      if (over_ == "seed")
        by_seed_.emplace_back(at, m->value);
      else if (by_value_.size() < kMostValues || by_value_.contains(at))
        by_value_[at].add(m->value);
      return true;
    }
  }
  why = text
            ? fmt::format("{} is \"{}\" in `{}`: no number", over_, *text, result.run)
            : fmt::format("`{}` has no {}; a measure is drawn over seed or over the key of a --set", result.run, over_);
  return false;
}

bool SweepPlot::needs_another_look() {
  if (counting_ || !over_.empty()) return false;
  counting_ = true;
  low_ = all_.least(), high_ = all_.most();
  bins_.assign(high_ > low_ ? kBins : 1, 0);
  return true;
}

std::string SweepPlot::write(const std::string& path) const {
  Plot plot;
  plot.title = over_.empty() ? fmt::format("{} of {} runs", measure_, all_.count())
                             : fmt::format("{} over {}, {} runs", measure_, over_, all_.count());
  const auto limit_marks = [&](std::optional<double> limit, const char* words) {
    if (limit) plot.marks.push_back({*limit, fmt::format("{} {:g}", words, *limit), true});
  };
  if (over_.empty()) {
    plot.x_label = measure_;
    plot.y_label = "runs";
    Series runs{"", {}, true};
    const double width = high_ > low_ ? (high_ - low_) / static_cast<double>(bins_.size()) : 1;
    const double from = high_ > low_ ? low_ : low_ - 0.5;
    runs.points.emplace_back(from, 0);
    for (std::size_t i = 0; i < bins_.size(); ++i)
      runs.points.emplace_back(from + width * static_cast<double>(i), static_cast<double>(bins_[i]));
    runs.points.emplace_back(from + width * static_cast<double>(bins_.size()), 0);
    plot.series.push_back(std::move(runs));
    plot.marks.push_back({all_.at(0.5), fmt::format("median {:.3g}", all_.at(0.5)), false});
    limit_marks(limits_.at_most, "at most");
    limit_marks(limits_.at_least, "at least");
    return write_plots(path, std::span(&plot, 1));
  }
  plot.x_label = over_;
  plot.y_label = measure_;
  double from = 0, to = 0;
  if (over_ == "seed") {
    Series each{measure_, by_seed_, false};
    std::sort(each.points.begin(), each.points.end());
    if (!each.points.empty()) from = each.points.front().first, to = each.points.back().first;
    plot.series.push_back(std::move(each));
  } else {
    if (!by_value_.empty()) from = by_value_.begin()->first, to = by_value_.rbegin()->first;
    const bool alone =
        std::all_of(by_value_.begin(), by_value_.end(), [](const auto& v) { return v.second.count() == 1; });
    const bool small_is_bad = limits_.at_least && !limits_.at_most;
    const std::pair<const char*, double> lines[] = {
        {"median", 0.5}, {"95 %", small_is_bad ? 0.05 : 0.95}, {"worst", small_is_bad ? 0.0 : 1.0}};
    for (const auto& [name, share] : lines) {
      Series series{alone ? measure_ : name, {}, false};
      for (const auto& [value, spread] : by_value_) series.points.emplace_back(value, spread.at(share));
      plot.series.push_back(std::move(series));
      if (alone) break;
    }
  }
  if (limits_.at_most)
    plot.series.push_back({fmt::format("at most {:g}", *limits_.at_most), across(*limits_.at_most, from, to), false});
  if (limits_.at_least)
    plot.series.push_back(
        {fmt::format("at least {:g}", *limits_.at_least), across(*limits_.at_least, from, to), false});
  return write_plots(path, std::span(&plot, 1));
}

}  // namespace sinew::app
