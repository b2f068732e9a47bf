#include "apps/replay/comparison_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace sinew::app {
namespace {

using record::ComparedQuantity;

std::string relative_text(const ComparedQuantity& q) {
  const double r = q.relative();
  if (std::isinf(r)) return "-";
  if (r == 0) return "0";
  return r < 100 ? fmt::format("{:.3g} %", 100 * r) : fmt::format("{:.3g} x", r);
}

double seconds_at(const record::Deviation& d, rt::Time start) { return msg::seconds(d.max_at - start); }

nlohmann::ordered_json to_json(const record::Deviation& d, rt::Time start) {
  nlohmann::ordered_json json{{"messages", d.count}, {"rms", d.rms()}, {"max", d.max}};
  if (d.max > 0) json["max_at_s"] = seconds_at(d, start);
  return json;
}

std::size_t name_width(const std::vector<ComparedQuantity>& all, const std::string& heading) {
  std::size_t width = heading.size();
  for (const auto& q : all) width = std::max(width, q.name.size());
  return width;
}

}  // namespace

void sort_by_difference(std::vector<ComparedQuantity>& all) {
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.relative() > b.relative(); });
}

std::string comparison_table(const std::vector<ComparedQuantity>& sorted, rt::Time start, std::size_t most) {
  std::vector<ComparedQuantity> rows, true_ones;
  std::size_t same = 0, more = 0;
  for (const auto& q : sorted) {
    if (q.same())
      ++same;
    else if (rows.size() < most)
      rows.push_back(q);
    else
      ++more;
    if (q.recorded_from_truth.count > 0 && true_ones.size() < most) true_ones.push_back(q);
  }
  std::string out;
  if (!rows.empty()) {
    const std::size_t width = name_width(rows, "now against the record");
    out += fmt::format("{:<{}}  {:<7} {:>11} {:>11} {:>10} {:>9} {:>10}\n", "now against the record", width, "unit",
                       "RMS", "maximum", "at s", "messages", "of spread");
    for (const auto& q : rows) {
      out +=
          fmt::format("{:<{}}  {:<7} {:>11.4g} {:>11.4g} {:>10.3f} {:>9} {:>10}\n", q.name, width, q.unit, q.now.rms(),
                      q.now.max, q.now.max > 0 ? seconds_at(q.now, start) : 0.0, q.now.count, relative_text(q));
      if (q.one_sided > 0) out += fmt::format("  and in {} messages a number in one of both only\n", q.one_sided);
    }
  }
  if (more > 0) out += fmt::format("and {} more that differ: --fields shows others, --json all\n", more);
  if (same > 0) out += fmt::format("{}{} the same\n", same, rows.empty() ? " quantities, all" : " more are");
  if (true_ones.empty()) return out;
  const std::size_t width = name_width(true_ones, "RMS against the truth");
  out += fmt::format("{:<{}}  {:<7} {:>11} {:>11} {:>9}\n", "RMS against the truth", width, "unit", "recorded", "now",
                     "messages");
  for (const auto& q : true_ones)
    out += fmt::format("{:<{}}  {:<7} {:>11.4g} {:>11.4g} {:>9}\n", q.name, width, q.unit, q.recorded_from_truth.rms(),
                       q.now_from_truth.rms(), q.now_from_truth.count);
  return out;
}

nlohmann::ordered_json comparison_json(const ComparedQuantity& q, rt::Time start) {
  nlohmann::ordered_json json{{"name", q.name}, {"unit", q.unit}};
  json.update(to_json(q.now, start));
  json["one_sided"] = q.one_sided;
  json["spread"] = q.spread;
  if (q.has_truth)
    json["truth"] = {{"recorded", to_json(q.recorded_from_truth, start)}, {"now", to_json(q.now_from_truth, start)}};
  return json;
}

std::vector<Plot> comparison_plots(const std::vector<ComparedQuantity>& sorted, std::size_t most) {
  const bool any = std::any_of(sorted.begin(), sorted.end(), [](const auto& q) { return !q.same(); });
  std::vector<Plot> plots;
  for (const auto& q : sorted) {
    if (plots.size() == most || (any && q.same())) continue;
    Plot plot;
    plot.title = fmt::format("{}: now {:.3g} {} RMS from the record", q.name, q.now.rms(), q.unit);
    if (q.now_from_truth.count > 0)
      plot.title +=
          fmt::format("; from the truth {:.3g}, recorded {:.3g}", q.now_from_truth.rms(), q.recorded_from_truth.rms());
    plot.x_label = "time of the record (s)";
    plot.y_label = q.unit;
    for (const auto& [name, curve] : q.curves) plot.series.push_back({name, curve.points()});
    plots.push_back(std::move(plot));
  }
  return plots;
}

}  // namespace sinew::app
