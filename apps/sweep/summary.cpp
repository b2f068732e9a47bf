#include "apps/sweep/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "apps/sweep/case_text.hpp"

namespace sinew::sweep {
namespace {

using app::Json;

constexpr const char* kOthers = "(other outcomes)";
constexpr std::size_t kMostColumns = 3;  // of measures beside the variants

std::string figure(double value) {
  return value >= 1e4 || value <= -1e4 ? fmt::format("{:.0f}", value) : fmt::format("{:.4g}", value);
}

std::string percent(double share) {
  const double p = 100 * share;
  return p > 0 && p < 100 && (p < 0.1 || p > 99.9) ? fmt::format("{:.3f}", p) : fmt::format("{:.1f}", p);
}

/// Without the time at which it happened, so that equal ends count as one: "did not land: ... at 15.2 s".
std::string kind_of(std::string outcome) {
  for (std::size_t at = outcome.find(" at "); at != std::string::npos; at = outcome.find(" at ", at + 1)) {
    std::size_t end = at + 4;
    while (end < outcome.size() && (std::isdigit(static_cast<unsigned char>(outcome[end])) || outcome[end] == '.'))
      ++end;
    if (end > at + 4 && outcome.compare(end, 2, " s") == 0) outcome.erase(at, end + 2 - at);
  }
  return outcome.empty() ? "nothing to judge" : outcome;
}

Json interval_json(std::uint64_t part, std::uint64_t all) {
  const Interval between = wilson_95(part, all);
  return {{"runs", part},
          {"share", all == 0 ? Json() : Json(static_cast<double>(part) / static_cast<double>(all))},
          {"low", between.low},
          {"high", between.high}};
}

Json limits_json(const Limits& limits) {
  Json j = Json::object();
  if (limits.at_most) j["at_most"] = *limits.at_most;
  if (limits.at_least) j["at_least"] = *limits.at_least;
  return j;
}

/// What runs of this variant have and not all have; the robot file for one that has nothing of its own.
std::string distinct(const std::string& variant, const std::vector<std::string>& shared) {
  std::string text;
  for (const std::string& part : parts_of(variant))
    if (std::find(shared.begin(), shared.end(), part) == shared.end()) text += (text.empty() ? "" : " ") + part;
  return text.empty() ? "(nothing more)" : text;
}

}  // namespace

std::string table_text(const std::vector<std::vector<std::string>>& rows, std::string_view align) {
  std::vector<std::size_t> widths(align.size());
  for (const auto& row : rows)
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  std::string text;
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string space(widths[i] - row[i].size(), ' ');
      line += "  " + (align[i] == '>' ? space + row[i] : row[i] + space);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

void Summary::add(const CaseResult& result) {
  ++runs_;
  if (result.good) ++good_;
  std::string kind = kind_of(result.outcome);
  if (!outcomes_.contains(kind) && outcomes_.size() >= kMostOutcomes) kind = kOthers;
  Outcome& outcome = outcomes_[kind];
  ++outcome.runs;
  outcome.good = result.good && (outcome.runs == 1 || outcome.good);
  for (const MeasuredValue& measure : result.measures) add_measure(measure, result);
  add_variant(result);
  if (!result.good && failures_.size() < kMostFailures) failures_.push_back(result);
}

void Summary::add_measure(const MeasuredValue& measure, const CaseResult& result) {
  if (!measures_.contains(measure.name)) {
    measure_order_.push_back(measure.name);
    measures_[measure.name].limits = measure.limits;
  }
  Spread& spread = measures_[measure.name];
  spread.limits_differ = spread.limits_differ || spread.limits != measure.limits;
  const bool worse = spread.small_is_bad() ? measure.value < spread.worst : measure.value > spread.worst;
  if (spread.values.count() == 0 || worse) {
    spread.worst = measure.value;
    spread.worst_in = result;
    spread.worst_in.measures.clear();
    spread.worst_in.report = nullptr;
  }
  spread.values.add(measure.value);
}

void Summary::add_variant(const CaseResult& result) {
  const std::string name = without_seed(result.run);
  if (!variants_.contains(name)) {
    if (variants_.size() >= kMostVariants) {
      ++in_other_variants_;
      return;
    }
    variant_order_.push_back(name);
  }
  Variant& variant = variants_[name];
  ++variant.count.runs;
  if (result.good) ++variant.count.good;
  for (const MeasuredValue& m : result.measures) {
    const auto place = std::find(measure_order_.begin(), measure_order_.end(), m.name);
    if (place - measure_order_.begin() < static_cast<std::ptrdiff_t>(kMostColumns))
      variant.measures[m.name].add(m.value);
  }
}

std::vector<std::string> Summary::measures() const { return measure_order_; }

std::vector<std::pair<std::string, Summary::Outcome>> Summary::sorted_outcomes() const {
  std::vector<std::pair<std::string, Outcome>> all(outcomes_.begin(), outcomes_.end());
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) {
    return a.second.good != b.second.good ? a.second.good : a.second.runs > b.second.runs;
  });
  return all;
}

std::string Summary::outcome_rows() const {
  std::vector<std::vector<std::string>> rows{{"outcome", "runs", "share", "95 % interval"}};
  const auto row = [&](const std::string& name, std::uint64_t n) {
    const Interval between = wilson_95(n, runs_);
    rows.push_back({name, fmt::format("{}", n), percent(static_cast<double>(n) / static_cast<double>(runs_)) + " %",
                    fmt::format("{} .. {} %", percent(between.low), percent(between.high))});
  };
  row("good", good_);
  for (const auto& [name, outcome] : sorted_outcomes()) row((outcome.good ? "  " : "  BAD: ") + name, outcome.runs);
  return table_text(rows, "<>>>");
}

std::string Summary::measure_rows() const {
  if (measures_.empty()) return {};
  const auto shared = shared_parts();
  std::vector<std::vector<std::string>> rows{{"measure", "runs", "median", "95 %", "worst", "limit", "worst in"}};
  for (const std::string& name : measure_order_) {
    const Spread& s = measures_.at(name);
    const auto seed = seed_of(s.worst_in.run);
    std::string worst_in = variants_.size() > 1 ? distinct(without_seed(s.worst_in.run), shared) : "";
    if (seed) worst_in += (worst_in.empty() ? "" : " ") + ("--seed " + *seed);
    rows.push_back({name, fmt::format("{}", s.values.count()), figure(s.values.at(0.5)),
                    figure(s.values.at(s.small_is_bad() ? 0.05 : 0.95)), figure(s.worst),
                    to_string(s.limits) + (s.limits_differ ? " (differs)" : ""), worst_in});
  }
  return "\n" + table_text(rows, "<>>>><<");
}

std::vector<std::string> Summary::shared_parts() const {
  std::vector<std::string> shared = parts_of(variant_order_.front());
  for (const std::string& name : variant_order_) {
    const auto parts = parts_of(name);
    std::erase_if(shared, [&](const auto& p) { return std::find(parts.begin(), parts.end(), p) == parts.end(); });
  }
  return shared;
}

std::string Summary::variant_rows() const {
  if (variants_.size() < 2) return {};
  std::vector<std::vector<std::string>> rows{{"with", "runs", "good", "share", "95 % interval"}};
  std::string align = "<>>>>";
  const std::size_t columns = std::min(kMostColumns, measure_order_.size());
  for (std::size_t i = 0; i < columns; ++i) rows[0].push_back(measure_order_[i]), align += '>';
  const auto shared = shared_parts();
  for (std::size_t v = 0; v < variant_order_.size(); ++v) {
    const Variant& variant = variants_.at(variant_order_[v]);
    const auto [runs, good] = variant.count;
    const Interval between = wilson_95(good, runs);
    rows.push_back({distinct(variant_order_[v], shared), fmt::format("{}", runs), fmt::format("{}", good),
                    percent(static_cast<double>(good) / static_cast<double>(runs)) + " %",
                    fmt::format("{} .. {} %", percent(between.low), percent(between.high))});
    for (std::size_t i = 0; i < columns; ++i) {
      const auto it = variant.measures.find(measure_order_[i]);
      rows.back().push_back(it == variant.measures.end() ? "-" : figure(it->second.at(0.5)));
    }
  }
  std::string text = "\n" + table_text(rows, align);
  if (columns > 0) text += "  (measures: their medians)\n";
  if (in_other_variants_ > 0)
    text += fmt::format("  and others with {} runs: --csv has each run\n", in_other_variants_);
  return text;
}

std::string Summary::failure_rows() const {
  if (failures_.empty()) return {};
  std::string text = "\nfailures\n", told;
  for (const CaseResult& f : failures_) {
    const std::string reason = f.outcome + (f.why.empty() ? "" : ": " + f.why);
    if (reason != told) text += fmt::format("  {}\n", reason);  // once for several in a row
    told = reason;
    text += fmt::format("    {}\n", repeat_command(f.run));
  }
  if (const std::uint64_t all = runs_ - good_; all > failures_.size())
    text += fmt::format("  and {} more: --csv has each run\n", all - failures_.size());
  return text;
}

std::string Summary::text(std::uint64_t cases) const {
  if (runs_ == 0) return fmt::format("no run of {} has ended\n", cases);
  std::string text = outcome_rows();
  if (runs_ < cases) text += fmt::format("  ({} of {} runs)\n", runs_, cases);
  return text + measure_rows() + variant_rows() + failure_rows();
}

Json Summary::json(std::uint64_t cases) const {
  Json all{{"cases", cases}, {"runs", runs_}, {"good", interval_json(good_, runs_)}};
  all["outcomes"] = all["measures"] = all["variants"] = all["failures"] = Json::array();
  for (const auto& [name, outcome] : sorted_outcomes()) {
    Json one{{"outcome", name}, {"good", outcome.good}};
    one.update(interval_json(outcome.runs, runs_));
    all["outcomes"].push_back(std::move(one));
  }
  for (const std::string& name : measure_order_) {
    const Spread& s = measures_.at(name);
    Json one{{"name", name},
             {"runs", s.values.count()},
             {"median", s.values.at(0.5)},
             {"p95", s.values.at(s.small_is_bad() ? 0.05 : 0.95)},
             {"worst", s.worst},
             {"worst_case", s.worst_in.number},
             {"worst_run", s.worst_in.run}};
    one.update(limits_json(s.limits));
    all["measures"].push_back(std::move(one));
  }
  for (const std::string& name : variant_order_) {
    const Variant& variant = variants_.at(name);
    Json one{
        {"run", name}, {"runs", variant.count.runs}, {"good", interval_json(variant.count.good, variant.count.runs)}};
    for (const auto& [measure, values] : variant.measures) one["medians"][measure] = values.at(0.5);
    all["variants"].push_back(std::move(one));
  }
  for (const CaseResult& f : failures_)
    all["failures"].push_back({{"case", f.number},
                               {"outcome", f.outcome},
                               {"why", f.why},
                               {"code", f.code},
                               {"command", repeat_command(f.run)}});
  return all;
}

}  // namespace sinew::sweep
